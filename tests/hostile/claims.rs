//! Headers that claim terabytes in a few bytes, and pictures that unpack to far more than they are: refused before memory is
//! taken.

use crate::mutation::right_sums;
use crate::readers::named;
use crate::trial::{ALONE, Trial, peak, say};
use exr::prelude::{Encoding, Image, SpecificChannels, Vec2, WritableImage};
use image::{ExtendedColorType, ImageEncoder};

/// What refusing may take: buffers of decoders, no pixels.
const REFUSAL: usize = 48 << 20;

/// Writes a number into a file at a place after a word.
fn put(file: &mut [u8], word: &[u8], skip: usize, bytes: &[u8]) {
    let at = file.windows(word.len()).position(|w| w == word).expect("the word") + word.len() + skip;
    file[at..at + bytes.len()].copy_from_slice(bytes);
}

/// An EXR whose headers all say this size.
fn exr_size(file: &[u8], [width, height]: [i32; 2]) -> Vec<u8> {
    let mut file = file.to_vec();
    let last = [(width - 1).to_le_bytes(), (height - 1).to_le_bytes()].concat();
    for word in [&b"dataWindow\0box2i\0\x10\0\0\0"[..], b"displayWindow\0box2i\0\x10\0\0\0"] {
        let places: Vec<usize> =
            (0..file.len() - word.len()).filter(|k| file[*k..].starts_with(word)).collect();
        for at in places {
            let at = at + word.len();
            file[at..at + 8].fill(0);
            file[at + 8..at + 16].copy_from_slice(&last);
        }
    }
    file
}

fn png_size(file: &[u8], size: [u32; 2]) -> Vec<u8> {
    let mut file = file.to_vec();
    put(&mut file, b"IHDR", 0, &size.map(u32::to_be_bytes).concat());
    right_sums(&mut file);
    file
}

fn jpeg_size(file: &[u8], size: [u16; 2]) -> Vec<u8> {
    let mut file = file.to_vec();
    // Length, bits, then rows and columns.
    put(&mut file, &[0xff, 0xc0], 3, &size.map(u16::to_be_bytes).concat());
    file
}

fn hdr_size(size: [u64; 2]) -> Vec<u8> {
    format!("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y {} +X {}\n\x02\x02\x7f\x7f", size[1], size[0])
        .into_bytes()
}

fn glb_of_buffers(count: usize) -> Vec<u8> {
    let many = vec![r#"{"byteLength":1}"#; count].join(",");
    let mut json =
        format!(r#"{{"asset":{{"version":"2.0"}},"scenes":[{{}}],"buffers":[{many}]}}"#).into_bytes();
    json.resize(json.len().next_multiple_of(4), b' ');
    let data = vec![0; 1 << 17];
    let word = |n: usize| (n as u32).to_le_bytes();
    let head = [*b"glTF", word(2), word(28 + json.len() + data.len()), word(json.len()), *b"JSON"].concat();
    [head, json, word(data.len()).to_vec(), b"BIN\0".to_vec(), data].concat()
}

#[test]
fn headers_that_claim_terabytes_are_refused_at_once() {
    let _alone = ALONE.lock().unwrap_or_else(|e| e.into_inner());
    type Claim = Box<dyn Fn(&[u8]) -> Vec<u8>>;
    let mut claims: Vec<(&str, String, Claim)> = Vec::new();
    // The largest that formats can say, and the largest that our caps let pass.
    for size in
        [[1 << 29, 1 << 29], [65536, 65536], [65536, 2048], [16384, 8192], [1, 65536], [1 << 20, 1 << 10]]
    {
        for name in [
            "paint",
            "mix",
            "btf",
            "exr",
            "exr-rle",
            "exr-piz",
            "exr-pxr24",
            "exr-b44",
            "exr-tiles",
            "exr-raw",
            "print-exr",
        ] {
            claims.push((name, format!("{size:?}"), Box::new(move |file| exr_size(file, size))));
        }
    }
    for size in [[i32::MAX as u32; 2], [65536, 65536], [65536, 2048], [2048, 65536]] {
        for name in ["png", "print-png"] {
            claims.push((name, format!("{size:?}"), Box::new(move |file| png_size(file, size))));
        }
    }
    for size in [[65535, 65535], [2048, 65535], [65535, 2048]] {
        claims.push(("jpeg", format!("{size:?}"), Box::new(move |file| jpeg_size(file, size))));
    }
    for size in
        [[u64::MAX, u64::MAX], [u32::MAX.into(), 1], [1, u32::MAX.into()], [65536, 65536], [65536, 2048]]
    {
        claims.push(("hdr", format!("{size:?}"), Box::new(move |_| hdr_size(size))));
    }
    for word in [u32::MAX, 0x8000_0000, 0x7fff_ffff] {
        let word = word.to_le_bytes();
        for (name, places) in [
            ("merl", &[0, 4, 8][..]),
            ("mbsdf", &[43, 47, 51]),
            ("rgl", &[14]),
            // The lengths of the file and of its first part; of the second, which comes after the JSON.
            ("glb", &[8, 12]),
        ] {
            for at in places.iter().copied() {
                let change = move |file: &[u8]| {
                    let mut file = file.to_vec();
                    file[at..at + 4].copy_from_slice(&word);
                    file
                };
                claims.push((name, format!("{word:?} at {at}"), Box::new(change)));
            }
        }
        let binary = move |file: &[u8]| {
            let mut file = file.to_vec();
            let at = file.windows(4).position(|w| w == b"BIN\0").expect("the second part") - 4;
            file[at..at + 4].copy_from_slice(&word);
            file
        };
        claims.push(("glb", format!("second part {word:?}"), Box::new(binary)));
    }
    // Buffers by the thousand, all of them the one of the file, or the file itself.
    claims.push(("glb", "4000 buffers".into(), Box::new(|_| glb_of_buffers(4000))));
    let many = [r#"{"uri":"a.gltf","byteLength":1}"#; 9000].join(",");
    let many = format!(r#"{{"asset":{{"version":"2.0"}},"scenes":[{{}}],"buffers":[{many}]}}"#);
    claims.push(("gltf", "9000 buffers".into(), Box::new(move |_| many.clone().into_bytes())));
    // Brackets within brackets: a parser that calls itself runs out of stack, which nobody can catch.
    for name in ["ink", "capture", "truth", "calibration", "axf", "gltf", "paint-json"] {
        claims.push((name, "deep list".into(), Box::new(|_| b"[".repeat(200_000))));
        claims.push((name, "deep object".into(), Box::new(|_| b"{\"a\":".repeat(200_000))));
    }
    for name in ["composition", "scene", "dome"] {
        claims.push((
            name,
            "deep list".into(),
            Box::new(|_| [b"a = ".to_vec(), b"[".repeat(200_000)].concat()),
        ));
        claims.push((
            name,
            "deep table".into(),
            Box::new(|_| [b"a".to_vec(), b".a".repeat(200_000), b" = 1".to_vec()].concat()),
        ));
        claims.push((
            name,
            "deep header".into(),
            Box::new(|_| [b"[a".to_vec(), b".a".repeat(200_000), b"]".to_vec()].concat()),
        ));
    }
    let (mut most, mut faults) = (0, Vec::new());
    for (name, what, change) in &claims {
        let trial = Trial::new(named(name).expect("a reader"));
        let bytes = change(&trial.valid);
        let (outcome, memory) = peak(|| trial.read_bytes(&bytes));
        most = most.max(memory);
        // What is no JSON is no container's fault.
        let refused = outcome == Ok(false) || (*name == "paint-json" && outcome == Ok(true));
        // Files that a .gltf file names may have as much together as one may.
        let named_files = if what.ends_with("buffers") { 256 << 20 } else { 0 };
        if !refused || memory > REFUSAL + named_files + 20 * bytes.len() {
            faults.push(format!("{name} {what}: {outcome:?}, {memory} bytes of memory"));
        }
    }
    say(&format!(
        "claims: {} headers, {} faults, {} MiB of memory at most",
        claims.len(),
        faults.len(),
        most >> 20
    ));
    assert!(faults.is_empty(), "{faults:#?}");
}

/// A black picture of `side` x `side` pixels.
fn black_exr(path: &std::path::Path, side: usize) {
    let channels = SpecificChannels::rgb(|_: Vec2<usize>| (0f32, 0f32, 0f32));
    let image = Image::from_encoded_channels((side, side), Encoding::SMALL_LOSSLESS, channels);
    image.write().to_file(path).expect("writes");
}

/// Honest pictures of nothing, small on the disk: read, in the memory of their pixels (12 bytes each as RGB, and once more while
/// they are converted).
#[test]
fn pictures_of_nothing_take_the_memory_of_their_pixels() {
    let _alone = ALONE.lock().unwrap_or_else(|e| e.into_inner());
    const SIDE: usize = 3000;
    let trial = Trial::new(named("exr").expect("a reader"));
    black_exr(&trial.path, SIDE);
    let length = std::fs::metadata(&trial.path).unwrap().len();
    let (outcome, exr) = peak(|| trial.read());
    assert_eq!(outcome, Ok(true));
    let trial = Trial::new(named("png").expect("a reader"));
    let file = std::fs::File::create(&trial.path).unwrap();
    let codes = vec![0u8; 3 * SIDE * SIDE];
    image::codecs::png::PngEncoder::new(file)
        .write_image(&codes, SIDE as u32, SIDE as u32, ExtendedColorType::Rgb8)
        .unwrap();
    drop(codes);
    let (outcome, png) = peak(|| trial.read());
    assert_eq!(outcome, Ok(true));
    say(&format!(
        "{SIDE} x {SIDE} black pixels in {length} bytes: EXR {} MiB, PNG {} MiB",
        exr >> 20,
        png >> 20
    ));
    let pixels = 12 * SIDE * SIDE;
    assert!(exr < pixels + REFUSAL, "{exr}");
    // Codes of a byte each, f32, and linear.
    assert!(png < 2 * pixels + pixels / 4 + REFUSAL, "{png}");
}

/// Blocks that unpack to more than the header says.
#[test]
fn a_block_that_unpacks_to_more_than_it_should_is_refused() {
    let _alone = ALONE.lock().unwrap_or_else(|e| e.into_inner());
    for name in ["exr", "exr-zip1", "exr-rle", "exr-piz", "exr-pxr24", "paint"] {
        let trial = Trial::new(named(name).expect("a reader"));
        black_exr(&trial.path, 4096);
        let bomb = exr_size(&std::fs::read(&trial.path).unwrap(), [8, 4096]);
        let (outcome, memory) = peak(|| trial.read_bytes(&bomb));
        assert_eq!(outcome, Ok(false), "{name}");
        assert!(memory < REFUSAL, "{name}: {memory}");
    }
}
