//! Arrays for NumPy: `.npy` (NumPy enhancement proposal 1, version 1.0), several in a `.npz`, which is a ZIP archive whose
//! members are stored as they are. Always little-endian, in the order of C.

use std::io::{self, Seek, Write};
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipWriter};

/// Numbers that arrays are made of.
pub trait Number: Copy {
    /// As NumPy names the type.
    const NAME: &'static str;
    fn put(self, bytes: &mut Vec<u8>);
}

macro_rules! number {
    ($($kind:ty: $name:literal),*) => {$(
        impl Number for $kind {
            const NAME: &'static str = $name;
            fn put(self, bytes: &mut Vec<u8>) {
                bytes.extend(self.to_le_bytes());
            }
        }
    )*};
}
number!(f64: "<f8", f32: "<f4", u32: "<u4", i32: "<i4", i64: "<i8", u8: "|u1");

/// An archive of arrays that is being written.
pub struct Npz<W: Write + Seek> {
    zip: ZipWriter<W>,
}

impl<W: Write + Seek> Npz<W> {
    pub fn new(out: W) -> Self {
        Self { zip: ZipWriter::new(out) }
    }

    /// Begins an array whose numbers follow by [`Npz::put`], row by row.
    pub fn begin<T: Number>(&mut self, name: &str, shape: &[usize]) -> io::Result<()> {
        self.begin_as(name, T::NAME, shape)
    }

    pub fn put<T: Number>(&mut self, numbers: impl IntoIterator<Item = T>) -> io::Result<()> {
        let mut bytes = Vec::new();
        numbers.into_iter().for_each(|number| number.put(&mut bytes));
        self.zip.write_all(&bytes)
    }

    /// A whole array; `shape` is empty for a number alone.
    pub fn array<T: Number>(
        &mut self,
        name: &str,
        shape: &[usize],
        numbers: impl IntoIterator<Item = T>,
    ) -> io::Result<()> {
        self.begin::<T>(name, shape)?;
        self.put(numbers)
    }

    /// An array of texts.
    pub fn texts(&mut self, name: &str, texts: &[&str]) -> io::Result<()> {
        let longest = texts.iter().map(|text| text.chars().count()).max().unwrap_or(0).max(1);
        self.begin_as(name, &format!("<U{longest}"), &[texts.len()])?;
        // UCS-4, filled up with zeros.
        self.put(texts.iter().flat_map(|text| text.chars().map(u32::from).chain(std::iter::repeat(0)).take(longest)))
    }

    pub fn finish(self) -> io::Result<()> {
        self.zip.finish()?;
        Ok(())
    }

    fn begin_as(&mut self, name: &str, kind: &str, shape: &[usize]) -> io::Result<()> {
        // Stored and dated with the beginning of the format's time, so that the same arrays are the same bytes.
        let options = SimpleFileOptions::default()
            .compression_method(CompressionMethod::Stored)
            .last_modified_time(zip::DateTime::DEFAULT)
            .large_file(true);
        self.zip.start_file(format!("{name}.npy"), options)?;
        self.zip.write_all(&header(kind, shape))
    }
}

/// What stands before the numbers of an array.
fn header(kind: &str, shape: &[usize]) -> Vec<u8> {
    const BEFORE: usize = 10;
    // The data are to begin at a multiple of this, for whoever maps them into memory.
    const ALIGNMENT: usize = 64;
    let comma = if shape.len() == 1 { "," } else { "" };
    let sizes: Vec<String> = shape.iter().map(usize::to_string).collect();
    let mut text = format!("{{'descr': '{kind}', 'fortran_order': False, 'shape': ({}{comma}), }}", sizes.join(", "));
    let length = (BEFORE + text.len() + 1).next_multiple_of(ALIGNMENT) - BEFORE;
    text += &" ".repeat(length - 1 - text.len());
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend((length as u16).to_le_bytes());
    bytes.extend(text.bytes());
    bytes.push(b'\n');
    bytes
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use std::io::{Cursor, Read};

    /// Header and data of an array, by the archive's own reader.
    pub fn member(file: &[u8], name: &str) -> (String, Vec<u8>) {
        let mut archive = zip::ZipArchive::new(Cursor::new(file)).unwrap();
        let mut bytes = Vec::new();
        archive.by_name(&format!("{name}.npy")).unwrap().read_to_end(&mut bytes).unwrap();
        assert_eq!(&bytes[..8], b"\x93NUMPY\x01\x00");
        let length = usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
        assert_eq!((10 + length) % 64, 0);
        (String::from_utf8(bytes[10..10 + length].to_vec()).unwrap(), bytes[10 + length..].to_vec())
    }

    pub fn numbers(data: &[u8]) -> Vec<f64> {
        data.as_chunks::<8>().0.iter().map(|&bytes| f64::from_le_bytes(bytes)).collect()
    }

    #[test]
    fn arrays_of_an_archive_read_back() {
        let mut file = Cursor::new(Vec::new());
        let mut npz = Npz::new(&mut file);
        npz.array("rest", &[2, 2], [0.1, 1.0 / 3.0, -0.0, 1e300]).unwrap();
        npz.array("rate", &[], [24.0]).unwrap();
        npz.texts("names", &["a", "häb"]).unwrap();
        npz.begin::<i32>("long", &[3]).unwrap();
        npz.put([1, -2]).unwrap();
        npz.put([3]).unwrap();
        npz.finish().unwrap();
        let file = file.into_inner();
        let (header, data) = member(&file, "rest");
        assert_eq!(header.trim_end(), "{'descr': '<f8', 'fortran_order': False, 'shape': (2, 2), }");
        assert_eq!(numbers(&data), [0.1, 1.0 / 3.0, -0.0, 1e300]);
        assert!(member(&file, "rate").0.contains("'shape': ()"));
        let (header, data) = member(&file, "names");
        assert!(header.contains("'<U3'") && header.contains("(2,)"));
        assert_eq!(data.len(), 2 * 3 * 4);
        assert_eq!(member(&file, "long").1, [1, 0, 0, 0, 254, 255, 255, 255, 3, 0, 0, 0]);
    }
}
