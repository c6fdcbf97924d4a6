//! PNG files in memory: the only image format that leaves the core.

use png::{BitDepth, ColorType, Compression, Encoder};

use cadet_base::error::{Error, Result};

/// Room for a file's headers, bytes.
const HEADERS: usize = 1024;

/// Encodes 8-bit RGB, row-major.
///
/// # Errors
/// [`Error::Image`] where the size does not fit the pixels.
pub fn encode_rgb8(width: u32, height: u32, pixels: &[u8]) -> Result<Vec<u8>> {
    encode(width, height, ColorType::Rgb, BitDepth::Eight, 3, pixels)
}

/// Encodes 8-bit RGB and opacity, row-major: the objects of banks.
///
/// # Errors
/// [`Error::Image`] where the size does not fit the pixels.
pub fn encode_rgba8(width: u32, height: u32, pixels: &[u8]) -> Result<Vec<u8>> {
    encode(width, height, ColorType::Rgba, BitDepth::Eight, 4, pixels)
}

/// Encodes 8-bit gray, row-major: the semantic image.
///
/// # Errors
/// [`Error::Image`] where the size does not fit the pixels.
pub fn encode_gray8(width: u32, height: u32, pixels: &[u8]) -> Result<Vec<u8>> {
    encode(width, height, ColorType::Grayscale, BitDepth::Eight, 1, pixels)
}

/// Encodes 16-bit gray, row-major: depth and instances.
///
/// # Errors
/// [`Error::Image`] where the size does not fit the pixels.
pub fn encode_gray16(width: u32, height: u32, pixels: &[u16]) -> Result<Vec<u8>> {
    let big_endian: Vec<u8> = pixels.iter().flat_map(|p| p.to_be_bytes()).collect();
    encode(width, height, ColorType::Grayscale, BitDepth::Sixteen, 2, &big_endian)
}

/// Encodes 16-bit RGB, row-major: vectors such as KITTI's optical flow.
///
/// # Errors
/// [`Error::Image`] where the size does not fit the pixels.
pub fn encode_rgb16(width: u32, height: u32, pixels: &[u16]) -> Result<Vec<u8>> {
    let big_endian: Vec<u8> = pixels.iter().flat_map(|p| p.to_be_bytes()).collect();
    encode(width, height, ColorType::Rgb, BitDepth::Sixteen, 6, &big_endian)
}

fn encode(
    width: u32,
    height: u32,
    color: ColorType,
    depth: BitDepth,
    bytes_per_pixel: usize,
    bytes: &[u8],
) -> Result<Vec<u8>> {
    let expected = width as usize * height as usize * bytes_per_pixel;
    if expected == 0 || bytes.len() != expected {
        return Err(Error::Image { reason: format!("{} bytes for {width} x {height}, not {expected}", bytes.len()) });
    }
    let failed = |e: png::EncodingError| Error::Image { reason: e.to_string() };
    let mut out = Vec::with_capacity(expected / 2 + HEADERS);
    let mut encoder = Encoder::new(&mut out, width, height);
    encoder.set_color(color);
    encoder.set_depth(depth);
    encoder.set_compression(Compression::Fast);
    let mut writer = encoder.write_header().map_err(failed)?;
    writer.write_image_data(bytes).map_err(failed)?;
    writer.finish().map_err(failed)?;
    Ok(out)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image_file::{PixelValues, decode};

    #[test]
    fn images_come_back_as_they_were() {
        let pixels: Vec<u8> = (0..7 * 5 * 4_u32).map(|i| (i * 37 % 256) as u8).collect();
        for (file, width, channels) in [
            (encode_rgba8(7, 5, &pixels).unwrap(), 7, 4),
            (encode_rgb8(7, 5, &pixels[..105]).unwrap(), 7, 3),
            (encode_gray8(15, 5, &pixels[..75]).unwrap(), 15, 1),
        ] {
            let back = decode(&file, 75).unwrap();
            assert_eq!((back.width, back.height, back.channels), (width, 5, channels));
            assert_eq!(back.samples, PixelValues::Eight(pixels[..width as usize * 5 * channels].to_vec()));
        }
        let deep: Vec<u16> = (0..35).map(|i| i * 1871).collect();
        let back = decode(&encode_gray16(7, 5, &deep).unwrap(), 35).unwrap();
        assert_eq!((back.channels, back.samples), (1, PixelValues::Sixteen(deep.clone())));
        let back = decode(&encode_rgb16(7, 1, &deep[..21]).unwrap(), 35).unwrap();
        assert_eq!((back.channels, back.samples), (3, PixelValues::Sixteen(deep[..21].to_vec())));
    }

    #[test]
    fn a_wrong_size_is_refused_with_its_numbers() {
        for bad in [encode_rgb8(2, 2, &[0; 11]), encode_gray8(0, 4, &[]), encode_gray16(2, 2, &[0; 5])] {
            assert!(bad.unwrap_err().to_string().contains("bytes for"));
        }
    }
}
