//! The two images that FLIP compares.

/// Red, green and blue, row by row, linear sRGB.
pub type Planes<'a> = [&'a [f32]; 3];

/// Two images of one size.
#[derive(Clone, Copy, Debug)]
pub struct Images<'a> {
    /// The image that counts as the truth.
    pub reference: Planes<'a>,
    /// The image that is compared with it.
    pub test: Planes<'a>,
    /// Texels a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
}
