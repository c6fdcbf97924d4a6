//! Image files of others: PNG, JPEG and WebP, decoded only if their headers keep to a limit.

use std::fmt::Display;
use std::io::Cursor;
use std::panic::{UnwindSafe, catch_unwind};

use image_webp::WebPDecoder;
use png::{BitDepth, ColorType, Transformations};
use zune_jpeg::JpegDecoder;
use zune_jpeg::errors::DecodeErrors;
use zune_jpeg::zune_core::bytestream::ZCursor;
use zune_jpeg::zune_core::colorspace::ColorSpace;
use zune_jpeg::zune_core::options::DecoderOptions;

use cadet_base::error::{Error, Result};

/// Scans of a progressive JPEG: encoders write about ten, and each costs a pass over the image.
const MAX_SCANS: usize = 64;
/// How Git's extension for large files begins what it leaves in place of one.
const LFS_POINTER: &[u8] = b"version https://git-lfs";
/// The longest side that the format of JPEG holds.
const MAX_JPEG_SIDE: usize = 65_535;

/// Samples of one depth, row-major, channel by channel within a pixel.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum PixelValues {
    /// 8 bits each.
    Eight(Vec<u8>),
    /// 16 bits each.
    Sixteen(Vec<u16>),
}

/// What an image file holds, as stored: no orientation, gamma or color profile is applied.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Picture {
    /// Pixels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// 1 is gray, 2 gray and opacity, 3 RGB, 4 RGB and opacity.
    pub channels: usize,
    /// `height * width * channels` of them.
    pub samples: PixelValues,
    /// The format's name.
    pub format: &'static str,
    /// Whether the file holds numbers of colors; they have become RGB.
    pub is_palette: bool,
    /// Whether the file holds an animation, of which this is the image that programs show that know none.
    pub is_animation: bool,
}

/// Decodes a file of at most `max_pixels`.
///
/// # Errors
/// [`Error::ImageFile`] for another format, a damaged or cut file, and more pixels.
pub fn decode(data: &[u8], max_pixels: u64) -> Result<Picture> {
    let decoded = match data {
        [0x89, b'P', b'N', b'G', ..] => caught("PNG", || decode_png(data, max_pixels)),
        [0xff, 0xd8, 0xff, ..] => caught("JPEG", || decode_jpeg(data, max_pixels)),
        [b'R', b'I', b'F', b'F', _, _, _, _, b'W', b'E', b'B', b'P', ..] => {
            caught("WebP", || decode_webp(data, max_pixels))
        }
        [] => Err("the file is empty; copy or save it again".to_owned()),
        _ if data.starts_with(LFS_POINTER) => {
            Err("a pointer of Git LFS in place of the image; run `git lfs pull`".to_owned())
        }
        _ => Err(format!("no PNG, JPEG or WebP image ({} bytes); save it as PNG", data.len())),
    };
    decoded.map_err(|reason| Error::ImageFile { reason })
}

/// Takes a panic for what it is in a decoder that others wrote: a file that breaks its format where nobody looked.
fn caught(
    format: &str,
    decode: impl FnOnce() -> std::result::Result<Picture, String> + UnwindSafe,
) -> std::result::Result<Picture, String> {
    catch_unwind(decode).unwrap_or_else(|_| Err(damaged(format, "its decoder stopped")))
}

fn decode_png(data: &[u8], max_pixels: u64) -> std::result::Result<Picture, String> {
    let refused = |error: png::DecodingError| match error {
        png::DecodingError::IoError(_) => truncated("PNG", data),
        error => damaged("PNG", error),
    };
    let mut decoder = png::Decoder::new(Cursor::new(data));
    decoder.set_transformations(Transformations::EXPAND);
    decoder.set_ignore_text_chunk(true);
    decoder.set_ignore_iccp_chunk(true);
    let header = decoder.read_header_info().map_err(refused)?;
    let (width, height, is_palette) = (header.width, header.height, header.color_type == ColorType::Indexed);
    check_size(width.into(), height.into(), max_pixels)?;
    let mut reader = decoder.read_info().map_err(refused)?;
    let is_animation = reader.info().animation_control.is_some();
    let (color, depth) = reader.output_color_type();
    let size = reader.output_buffer_size().ok_or_else(|| damaged("PNG", "no size"))?;
    let mut bytes = vec![0; size];
    let frame = reader.next_frame(&mut bytes).map_err(refused)?;
    if (frame.width, frame.height) != (width, height) {
        return Err(damaged("PNG", "an animation whose first frame is not the whole image"));
    }
    if !is_animation {
        // What is cut behind its pixels is a cut file, too.
        reader.finish().map_err(refused)?;
    }
    let samples = if depth == BitDepth::Sixteen {
        PixelValues::Sixteen(bytes.chunks_exact(2).map(|pair| u16::from_be_bytes([pair[0], pair[1]])).collect())
    } else {
        PixelValues::Eight(bytes)
    };
    Ok(Picture { width, height, channels: color.samples(), samples, format: "PNG", is_palette, is_animation })
}

fn decode_jpeg(data: &[u8], max_pixels: u64) -> std::result::Result<Picture, String> {
    let refused = |error: DecodeErrors| match error {
        DecodeErrors::ExhaustedData | DecodeErrors::IoErrors(_) => truncated("JPEG", data),
        error => damaged("JPEG", error),
    };
    // Strict, since what else is lost would become gray.
    let options = DecoderOptions::default()
        .set_strict_mode(true)
        .set_max_width(MAX_JPEG_SIDE)
        .set_max_height(MAX_JPEG_SIDE)
        .jpeg_set_max_scans(MAX_SCANS);
    let mut decoder = JpegDecoder::new_with_options(ZCursor::new(data), options);
    decoder.decode_headers().map_err(refused)?;
    let (width, height) = decoder.dimensions().ok_or_else(|| damaged("JPEG", "no size"))?;
    check_size(width as u64, height as u64, max_pixels)?;
    let is_gray = decoder.input_colorspace() == Some(ColorSpace::Luma);
    let color = if is_gray { ColorSpace::Luma } else { ColorSpace::RGB };
    decoder.set_options(options.jpeg_set_out_colorspace(color));
    let bytes = decoder.decode().map_err(refused)?;
    let channels = color.num_components();
    if bytes.len() != width * height * channels {
        return Err(damaged("JPEG", "channels that are no colors"));
    }
    Ok(Picture {
        width: width as u32,
        height: height as u32,
        channels,
        samples: PixelValues::Eight(bytes),
        format: "JPEG",
        is_palette: false,
        is_animation: false,
    })
}

fn decode_webp(data: &[u8], max_pixels: u64) -> std::result::Result<Picture, String> {
    let refused = |error: image_webp::DecodingError| match error {
        image_webp::DecodingError::IoError(_) => truncated("WebP", data),
        image_webp::DecodingError::ImageTooLarge => {
            format!("too many pixels, at most {max_pixels} are read; scale it down")
        }
        error => damaged("WebP", error),
    };
    let mut decoder = WebPDecoder::new(Cursor::new(data)).map_err(refused)?;
    let (width, height) = decoder.dimensions();
    check_size(width.into(), height.into(), max_pixels)?;
    let size = decoder.output_buffer_size().ok_or_else(|| damaged("WebP", "no size"))?;
    let mut bytes = vec![0; size];
    decoder.read_image(&mut bytes).map_err(refused)?;
    Ok(Picture {
        width,
        height,
        channels: if decoder.has_alpha() { 4 } else { 3 },
        samples: PixelValues::Eight(bytes),
        format: "WebP",
        is_palette: false,
        is_animation: decoder.is_animated(),
    })
}

fn check_size(width: u64, height: u64, max_pixels: u64) -> std::result::Result<(), String> {
    if width.saturating_mul(height) > max_pixels {
        return Err(format!("{width} x {height} pixels, at most {max_pixels} are read; scale it down"));
    }
    Ok(())
}

fn truncated(format: &str, data: &[u8]) -> String {
    format!("truncated {format} image ({} bytes); copy or save it again", data.len())
}

fn damaged(format: &str, error: impl Display) -> String {
    let reason = error.to_string().split_whitespace().collect::<Vec<_>>().join(" ");
    format!("damaged {format} image: {}; copy or save it again", reason.trim_matches(['"', '.']))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::png::encode_rgb8;

    const LIMIT: u64 = 35;

    fn reason(data: &[u8]) -> String {
        decode(data, LIMIT).unwrap_err().to_string()
    }

    #[test]
    fn every_cut_and_every_larger_image_is_refused() {
        let file = encode_rgb8(7, 5, &[9; 105]).unwrap();
        for end in 8..file.len() {
            assert!(reason(&file[..end]).starts_with("truncated PNG image"), "{end}: {}", reason(&file[..end]));
        }
        assert_eq!(reason(&encode_rgb8(6, 6, &[0; 108]).unwrap()), "6 x 6 pixels, at most 35 are read; scale it down");
        assert_eq!(reason(b"GIF89a"), "no PNG, JPEG or WebP image (6 bytes); save it as PNG");
    }
}
