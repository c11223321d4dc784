//! The header of a PLY file: the elements that follow, and the way they are stored.

use super::error::{FilePlace, MeshFileError};

/// Largest number of tables in a file; files in the wild have two to four.
const MOST_ELEMENTS: usize = 256;

/// The encoding of the body's numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PlyEncoding {
    Ascii,
    LittleEndian,
    BigEndian,
}

/// The type of a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PlyScalar {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl PlyScalar {
    fn of_name(name: &str) -> Option<Self> {
        Some(match name {
            "char" | "int8" => Self::I8,
            "uchar" | "uint8" => Self::U8,
            "short" | "int16" => Self::I16,
            "ushort" | "uint16" => Self::U16,
            "int" | "int32" => Self::I32,
            "uint" | "uint32" => Self::U32,
            "float" | "float32" => Self::F32,
            "double" | "float64" => Self::F64,
            _ => return None,
        })
    }

    /// Bytes of a number in a binary file.
    pub fn bytes(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }
}

/// The layout of a property: one number, or a list of them with its length before.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PlyLayout {
    Number(PlyScalar),
    List { length: PlyScalar, item: PlyScalar },
}

/// A named number or list of every item of an element.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PlyProperty {
    pub name: String,
    pub layout: PlyLayout,
}

impl PlyProperty {
    /// True if it is no list.
    pub fn is_number(&self) -> bool {
        matches!(self.layout, PlyLayout::Number(_))
    }
}

/// A table of the body.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PlyElement {
    pub name: String,
    pub count: usize,
    pub properties: Vec<PlyProperty>,
}

impl PlyElement {
    /// The column of the first number of this name.
    pub fn number(&self, name: &str) -> Option<usize> {
        let is_it = |one: &PlyProperty| one.name == name && one.is_number();
        self.properties.iter().position(is_it)
    }
}

/// The contents of a header.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PlyHeader {
    pub encoding: PlyEncoding,
    pub elements: Vec<PlyElement>,
    /// The byte at which the body begins.
    pub body: usize,
    /// Number of lines of the header.
    pub lines: usize,
}

/// Reads the header at the beginning of a file.
pub fn parse(bytes: &[u8]) -> Result<PlyHeader, MeshFileError> {
    let mut header = PlyHeader {
        encoding: PlyEncoding::Ascii,
        elements: Vec::new(),
        body: 0,
        lines: 0,
    };
    let mut encoding = None;
    loop {
        let place = FilePlace::Line(header.lines + 1);
        let fail = |message: String| Err(MeshFileError::new(place, message));
        let rest = &bytes[header.body..];
        let Some(end) = rest.iter().position(|byte| *byte == b'\n') else {
            return fail("the header has no end_header".to_owned());
        };
        let Ok(line) = std::str::from_utf8(&rest[..end]) else {
            return fail("the header is not text".to_owned());
        };
        header.body += end + 1;
        header.lines += 1;
        let words: Vec<&str> = line.split_ascii_whitespace().collect();
        match words[..] {
            ["ply"] if header.lines == 1 => {}
            _ if header.lines == 1 => return fail("a PLY file begins with \"ply\"".to_owned()),
            [] | ["comment" | "obj_info", ..] => {}
            ["format", name, "1.0"] => {
                encoding = Some(match name {
                    "ascii" => PlyEncoding::Ascii,
                    "binary_little_endian" => PlyEncoding::LittleEndian,
                    "binary_big_endian" => PlyEncoding::BigEndian,
                    _ => {
                        return fail(format!(
                            "the format must be ascii, binary_little_endian or binary_big_endian, not \"{name}\""
                        ));
                    }
                });
            }
            ["element", name, count] => {
                let Ok(count) = count.parse() else {
                    return fail(format!("\"{count}\" is not a number of elements"));
                };
                if header.elements.len() == MOST_ELEMENTS {
                    return fail(format!("more than {MOST_ELEMENTS} elements"));
                }
                if header.elements.iter().any(|element| element.name == name) {
                    return fail(format!("element \"{name}\" is declared twice"));
                }
                header.elements.push(PlyElement {
                    name: name.to_owned(),
                    count,
                    properties: Vec::new(),
                });
            }
            ["property", .., name] => {
                let Some(layout) = layout(&words[1..words.len() - 1]) else {
                    return fail(format!(
                        "\"{}\" is not \"property type name\" or \"property list type type name\"",
                        line.trim_end()
                    ));
                };
                let Some(element) = header.elements.last_mut() else {
                    return fail("a property before the first element".to_owned());
                };
                element.properties.push(PlyProperty {
                    name: name.to_owned(),
                    layout,
                });
            }
            ["end_header"] => break,
            _ => return fail(format!("\"{}\" is not known in a header", line.trim_end())),
        }
    }
    let Some(encoding) = encoding else {
        return Err(MeshFileError::new(
            FilePlace::Line(header.lines),
            "the header names no format with version 1.0",
        ));
    };
    header.encoding = encoding;
    Ok(header)
}

fn layout(words: &[&str]) -> Option<PlyLayout> {
    match words {
        [number] => PlyScalar::of_name(number).map(PlyLayout::Number),
        ["list", length, item] => Some(PlyLayout::List {
            length: PlyScalar::of_name(length)?,
            item: PlyScalar::of_name(item)?,
        }),
        _ => None,
    }
}
