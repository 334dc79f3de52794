//! Numbers of a glTF file by accessor: every kind of component, normalized integers, strides, sparse replacements.

use super::document::{Document, EXPORT_AGAIN, named};
use crate::Error;
use gltf_json::accessor::{ComponentType, GenericComponentType, IndexComponentType, Type};
use gltf_json::buffer::View;
use gltf_json::validation::Checked;
use gltf_json::{Accessor, Index};

/// The numbers of an accessor, one element after the other.
pub struct Numbers {
    pub values: Vec<f64>,
    /// Numbers of an element.
    pub width: usize,
}

impl Numbers {
    /// How many elements there are.
    pub fn count(&self) -> usize {
        self.values.len() / self.width
    }

    pub fn element(&self, k: usize) -> &[f64] {
        &self.values[k * self.width..][..self.width]
    }
}

/// What is expected of an accessor.
#[derive(Clone, Copy)]
pub enum Wanted {
    /// Lengths, rotations, weights: floats, or integers that the file declares normalized; at times plain ones
    /// (`KHR_mesh_quantization`).
    Real,
    /// Indices: unsigned integers that are not normalized.
    Index,
}

impl Document {
    /// The numbers of accessor `index`, each element of the type `shape`.
    pub fn numbers(&mut self, index: Index<Accessor>, shape: Type, wanted: Wanted) -> Result<Numbers, Error> {
        let accessor = self.get(index, "accessor")?;
        let place = named("accessor", index.value(), accessor.name.as_ref());
        // Before anything is allocated.
        let count = usize::try_from(accessor.count.0).unwrap_or(usize::MAX);
        self.charge(count.saturating_mul(shape.multiplicity())).map_err(|e| e.within(&place))?;
        let accessor = self.get(index, "accessor")?;
        self.read(accessor, shape, wanted).map_err(|e| e.within(place))
    }

    fn read(&self, accessor: &Accessor, shape: Type, wanted: Wanted) -> Result<Numbers, Error> {
        let Checked::Valid(GenericComponentType(component)) = accessor.component_type else {
            return Err(Error::new("Its numbers are of no kind that glTF knows.", EXPORT_AGAIN));
        };
        if accessor.type_ != Checked::Valid(shape) {
            return Err(Error::new(format!("It is not of the type {shape:?}, which is needed here."), EXPORT_AGAIN));
        }
        let whole = matches!(component, ComponentType::U8 | ComponentType::U16 | ComponentType::U32);
        if matches!(wanted, Wanted::Index) && (!whole || accessor.normalized) {
            return Err(Error::new("Its numbers are no plain unsigned integers, as indices have to be.", EXPORT_AGAIN));
        }
        let width = shape.multiplicity();
        let count = usize::try_from(accessor.count.0).unwrap_or(usize::MAX);
        let size = count.saturating_mul(width);
        if count == 0 {
            return Err(Error::new("It has no elements.", EXPORT_AGAIN));
        }
        let layout = Layout { component, normalized: accessor.normalized, width };
        let mut values = match accessor.buffer_view {
            Some(view) => {
                let offset = accessor.byte_offset.map_or(0, |o| o.0);
                self.strided(self.get(view, "buffer view")?, offset, count, layout)
                    .map_err(|e| e.within(format!("buffer view {}", view.value())))?
            }
            // By the standard all are zero where there is no view; mostly sparse values replace some.
            None => vec![0.0; size],
        };
        if let Some(sparse) = &accessor.sparse {
            self.replace(&mut values, sparse, layout).map_err(|e| e.within("sparse values"))?;
        }
        match values.iter().position(|v| !v.is_finite()) {
            None => Ok(Numbers { values, width }),
            Some(k) => {
                let problem = format!("It has {} where a number should be.", values[k]);
                Err(Error::new(problem, EXPORT_AGAIN).within(format!("element {}", k / width)))
            }
        }
    }

    /// `count` elements of a view, from `offset` on.
    fn strided(&self, view: &View, offset: u64, count: usize, layout: Layout) -> Result<Vec<f64>, Error> {
        let buffer = self.buffers.get(view.buffer.value()).ok_or_else(|| {
            Error::new(format!("It names buffer {}, which does not exist.", view.buffer.value()), EXPORT_AGAIN)
        })?;
        let element = layout.bytes();
        let stride = view.byte_stride.map_or(element, |stride| stride.0);
        if stride < element {
            let problem = format!("Its elements of {element} bytes are {stride} bytes apart.");
            return Err(Error::new(problem, EXPORT_AGAIN));
        }
        let within = |bytes: &'_ [u8], start: u64, length: u64| {
            let end = start.checked_add(length).filter(|&end| end <= bytes.len() as u64);
            end.map(|end| start as usize..end as usize)
        };
        let cut = |needed: u64, there: usize| {
            let problem = format!("It is cut: its elements end at byte {needed}, there are {there} bytes.");
            Error::new(problem, EXPORT_AGAIN)
        };
        let (start, length) = (view.byte_offset.map_or(0, |o| o.0), view.byte_length.0);
        let range = within(buffer, start, length).ok_or_else(|| cut(start.saturating_add(length), buffer.len()))?;
        let bytes = &buffer[range];
        let needed = (count as u64 - 1).saturating_mul(stride as u64).saturating_add(element as u64);
        let range = within(bytes, offset, needed).ok_or_else(|| cut(offset.saturating_add(needed), bytes.len()))?;
        let elements = bytes[range].chunks(stride);
        Ok(elements.flat_map(|chunk| (0..layout.width).map(|k| layout.number(chunk, k))).collect())
    }

    fn replace(
        &self,
        values: &mut [f64],
        sparse: &gltf_json::accessor::sparse::Sparse,
        layout: Layout,
    ) -> Result<(), Error> {
        let Checked::Valid(IndexComponentType(component)) = sparse.indices.component_type else {
            return Err(Error::new("Their indices are of no kind that glTF knows.", EXPORT_AGAIN));
        };
        let elements = values.len() / layout.width;
        let count = usize::try_from(sparse.count.0).unwrap_or(usize::MAX);
        if count == 0 || count > elements {
            let problem = format!("There are {count} of them for {elements} elements.");
            return Err(Error::new(problem, EXPORT_AGAIN));
        }
        let of_indices = Layout { component, normalized: false, width: 1 };
        let view = self.get(sparse.indices.buffer_view, "buffer view")?;
        let indices = self.strided(view, sparse.indices.byte_offset.0, count, of_indices)?;
        let view = self.get(sparse.values.buffer_view, "buffer view")?;
        let replacements = self.strided(view, sparse.values.byte_offset.0, count, layout)?;
        for (k, (&index, value)) in indices.iter().zip(replacements.chunks(layout.width)).enumerate() {
            let index = index as usize;
            if index >= elements {
                let problem = format!("Number {k} replaces element {index} of {elements}.");
                return Err(Error::new(problem, EXPORT_AGAIN));
            }
            values[index * layout.width..][..layout.width].copy_from_slice(value);
        }
        Ok(())
    }
}

#[derive(Clone, Copy)]
struct Layout {
    component: ComponentType,
    normalized: bool,
    width: usize,
}

impl Layout {
    /// Bytes of an element. Columns of matrices of small numbers begin at multiples of four bytes; such matrices are
    /// used for nothing here, and 4x4 matrices have no gaps.
    fn bytes(self) -> usize {
        self.width * self.component.size()
    }

    /// Number `k` of an element; `element` holds at least [`Self::bytes`].
    fn number(self, element: &[u8], k: usize) -> f64 {
        let at = k * self.component.size();
        let two = || [element[at], element[at + 1]];
        let four = || [element[at], element[at + 1], element[at + 2], element[at + 3]];
        let (number, largest) = match self.component {
            ComponentType::I8 => (f64::from(element[at] as i8), f64::from(i8::MAX)),
            ComponentType::U8 => (f64::from(element[at]), f64::from(u8::MAX)),
            ComponentType::I16 => (f64::from(i16::from_le_bytes(two())), f64::from(i16::MAX)),
            ComponentType::U16 => (f64::from(u16::from_le_bytes(two())), f64::from(u16::MAX)),
            ComponentType::U32 => (f64::from(u32::from_le_bytes(four())), f64::from(u32::MAX)),
            ComponentType::F32 => return f64::from(f32::from_le_bytes(four())),
        };
        // The lowest signed integer stands for -1 as its neighbor does (glTF 2.0, section 3.11).
        if self.normalized { (number / largest).max(-1.0) } else { number }
    }
}
