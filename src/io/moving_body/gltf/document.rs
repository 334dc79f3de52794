//! The container of a glTF file, its JSON, and the bytes of its buffers.
//!
//! The JSON is read by `gltf-json`. The package `gltf` on top of it is not used here: it stops the program on files that are
//! broken in certain ways (a length of the container below 12, accessors that count nothing, sparse values that end early).

use crate::Error;
use base64::Engine;
use gltf_json::{Index, Root, root::Get};

/// More objects than any rigged character has; each takes some hundred bytes when it is read.
const MOST_OBJECTS: usize = 1_000_000;
/// All buffers of a file together, bytes.
const MOST_BUFFER_BYTES: usize = 1 << 30;
/// Numbers that all accessors together may ask for: files can ask for the same ones many times, or for zeros.
const MOST_NUMBERS: usize = 1 << 26;

pub const EXPORT_AGAIN: &str =
    "Export the file again; if that does not help, open it in another program and export it from there.";

/// Fetches the file that a buffer names, relative to the glTF file.
pub type Fetch<'a> = &'a mut dyn FnMut(&str) -> Result<Vec<u8>, Error>;

pub struct Document {
    pub root: Root,
    pub buffers: Vec<Vec<u8>>,
    /// How many more numbers may be read.
    budget: usize,
}

impl Document {
    pub fn open(bytes: &[u8], fetch: Fetch) -> Result<Self, Error> {
        let (json, binary) = if bytes.starts_with(b"glTF") { chunks(bytes)? } else { (bytes, None) };
        if json.iter().filter(|&&b| b == b'{').count() > MOST_OBJECTS {
            return Err(Error::new(
                format!("The glTF file has more than {MOST_OBJECTS} objects."),
                "Export the animated body alone, without the scene around it.",
            ));
        }
        let root = Root::from_slice(json).map_err(|e| {
            let error = Error::new(format!("It is not glTF 2.0: {e}."), EXPORT_AGAIN);
            error.within(format!("JSON, line {}, column {}", e.line(), e.column()))
        })?;
        check_asset(&root)?;
        let buffers = buffers(&root, binary, fetch)?;
        Ok(Self { root, buffers, budget: MOST_NUMBERS })
    }

    /// Takes so much from the budget.
    pub fn charge(&mut self, numbers: usize) -> Result<(), Error> {
        self.budget = self.budget.checked_sub(numbers).ok_or_else(|| {
            Error::new(
                "The file asks for more numbers than can be held.",
                "Export the animated body alone, with fewer vertices or keys.",
            )
        })?;
        Ok(())
    }

    /// The object of an index.
    pub fn get<T>(&self, index: Index<T>, what: &str) -> Result<&T, Error>
    where
        Root: Get<T>,
    {
        self.root.get(index).ok_or_else(|| {
            Error::new(format!("It names {what} {}, which does not exist.", index.value()), EXPORT_AGAIN)
        })
    }
}

/// `node 7 ("hips")`: how an object is named in messages.
pub fn named(what: &str, index: usize, name: Option<&String>) -> String {
    name.map_or_else(|| format!("{what} {index}"), |name| format!("{what} {index} \"{}\"", name.escape_debug()))
}

fn check_asset(root: &Root) -> Result<(), Error> {
    if !root.asset.version.starts_with("2.") {
        return Err(Error::new(
            format!("It is glTF {}, not 2.0.", root.asset.version.escape_debug()),
            "Convert it to glTF 2.0, for instance by loading it into Blender and exporting it.",
        ));
    }
    /// These change neither where vertices are nor how they are stored.
    const HARMLESS: [&str; 4] = ["KHR_materials_", "KHR_texture_", "KHR_lights_", "KHR_mesh_quantization"];
    let needed = root.extensions_required.iter().find(|name| !HARMLESS.iter().any(|h| name.starts_with(h)));
    match needed {
        None => Ok(()),
        Some(name) => Err(Error::new(
            format!("The file cannot be read without the extension {}.", name.escape_debug()),
            "Export it without compression (Draco, meshopt) and without extensions.",
        )),
    }
}

fn word(bytes: &[u8], at: usize) -> Option<usize> {
    Some(u32::from_le_bytes(*bytes.get(at..)?.first_chunk()?) as usize)
}

/// The JSON and the binary chunk of a GLB file.
fn chunks(bytes: &[u8]) -> Result<(&[u8], Option<&[u8]>), Error> {
    let broken = |at: usize, problem: String| Error::new(problem, EXPORT_AGAIN).within(format!("byte {at}"));
    let cut = |at: usize| broken(at, format!("The GLB file ends too early: it has {} bytes.", bytes.len()));
    let version = word(bytes, 4).ok_or_else(|| cut(4))?;
    if version != 2 {
        return Err(broken(4, format!("The GLB container has the version {version}, not 2.")));
    }
    let length = word(bytes, 8).ok_or_else(|| cut(8))?;
    if length > bytes.len() {
        return Err(broken(8, format!("The GLB file is cut: it should have {length} bytes, it has {}.", bytes.len())));
    }
    // What stands behind the length that the file gives is no part of it.
    let bytes = &bytes[..length];
    let (mut json, mut binary) = (None, None);
    let mut at = 12;
    while at < bytes.len() && binary.is_none() {
        let (Some(size), Some(kind)) = (word(bytes, at), bytes.get(at + 4..at + 8)) else { return Err(cut(at)) };
        let Some(chunk) = bytes.get(at + 8..).and_then(|rest| rest.get(..size)) else {
            return Err(broken(at, format!("A chunk of {size} bytes goes beyond the end of the GLB file.")));
        };
        match kind {
            b"JSON" if json.is_none() => json = Some(chunk),
            b"BIN\0" => binary = Some(chunk),
            _ => {}
        }
        at += 8 + size;
    }
    let json = json.ok_or_else(|| broken(12, "The GLB file has no JSON chunk.".to_owned()))?;
    Ok((json, binary))
}

fn buffers(root: &Root, binary: Option<&[u8]>, fetch: Fetch) -> Result<Vec<Vec<u8>>, Error> {
    let mut total = 0;
    let mut buffers = Vec::new();
    for (k, buffer) in root.buffers.iter().enumerate() {
        let place = || named("buffer", k, buffer.name.as_ref());
        let mut bytes = match &buffer.uri {
            Some(uri) => referenced(uri, fetch),
            None if k == 0 => binary
                .map(<[u8]>::to_vec)
                .ok_or_else(|| Error::new("The file has no binary chunk, which its first buffer needs.", EXPORT_AGAIN)),
            None => Err(Error::new("The buffer says neither where its bytes are nor is it the first.", EXPORT_AGAIN)),
        }
        .map_err(|e| e.within(place()))?;
        let wanted = usize::try_from(buffer.byte_length.0).unwrap_or(usize::MAX);
        if bytes.len() < wanted {
            let problem = format!("The buffer is cut: it should have {wanted} bytes, there are {}.", bytes.len());
            return Err(Error::new(problem, EXPORT_AGAIN).within(place()));
        }
        bytes.truncate(wanted);
        total += bytes.len();
        if total > MOST_BUFFER_BYTES {
            let problem = format!("The buffers have more than {} MiB.", MOST_BUFFER_BYTES >> 20);
            return Err(Error::new(problem, "Export the animated body alone, without the scene around it."));
        }
        buffers.push(bytes);
    }
    Ok(buffers)
}

/// The bytes of a data URI, or of a file beside the glTF file.
fn referenced(uri: &str, fetch: Fetch) -> Result<Vec<u8>, Error> {
    if let Some(data) = uri.strip_prefix("data:") {
        let Some((_, coded)) = data.split_once(";base64,") else {
            return Err(Error::new("Its data URI is not in base64.", EXPORT_AGAIN));
        };
        return base64::engine::general_purpose::STANDARD
            .decode(coded)
            .map_err(|e| Error::new(format!("Its data URI is damaged: {e}."), EXPORT_AGAIN));
    }
    let shown = uri.chars().take(80).collect::<String>().escape_debug().to_string();
    if uri.contains(':') || uri.starts_with('/') || uri.starts_with('\\') {
        return Err(Error::new(
            format!("Its bytes are at \"{shown}\"."),
            "Only files beside the glTF file are read: put the buffer there and name it by its file name.",
        ));
    }
    match percent_encoding::percent_decode_str(uri).decode_utf8() {
        Ok(path) => fetch(&path),
        Err(_) => Err(Error::new(format!("Its file name \"{shown}\" is not UTF-8."), "Rename the file of the buffer.")),
    }
}
