//! Tensor files as the RGL material database keeps its measurements, and a small material.
#![allow(dead_code)]

/// A field of a tensor file: name, type code, shape, data.
pub struct Field(pub &'static str, pub u8, pub Vec<u64>, pub Vec<u8>);

pub fn floats(name: &'static str, shape: &[u64], values: impl IntoIterator<Item = f32>) -> Field {
    Field(name, 10, shape.to_vec(), values.into_iter().flat_map(f32::to_le_bytes).collect())
}

pub fn tensor_bytes(fields: &[Field]) -> Vec<u8> {
    let header: usize = 18 + fields.iter().map(|f| 13 + f.0.len() + 8 * f.2.len()).sum::<usize>();
    let mut bytes = b"tensor_file\0\x01\x00".to_vec();
    bytes.extend((fields.len() as u32).to_le_bytes());
    let mut data: Vec<u8> = Vec::new();
    for Field(name, kind, shape, values) in fields {
        bytes.extend((name.len() as u16).to_le_bytes());
        bytes.extend(name.as_bytes());
        bytes.extend((shape.len() as u16).to_le_bytes());
        bytes.push(*kind);
        bytes.extend(((header + data.len()) as u64).to_le_bytes());
        shape.iter().for_each(|side| bytes.extend(side.to_le_bytes()));
        data.extend(values);
    }
    bytes.extend(data);
    bytes
}

/// Numbers that are exact in f32: `low + (high - low) (k seed mod 101)/128`.
pub fn pattern(name: &'static str, shape: &[u64], seed: u64, low: f32, high: f32) -> Field {
    let count: u64 = shape.iter().product();
    floats(name, shape, (0..count).map(|k| low + (high - low) * ((k * seed % 101) as f32 / 128.0)))
}

/// Four angles of incidence, four wavelengths, 8 x 8 nodes.
pub fn spectral_fields() -> Vec<Field> {
    let sigma = [0.75, 0.625, 0.5, 0.375, 0.25];
    vec![
        floats("phi_i", &[1], [0.0]),
        floats("theta_i", &[4], [0.0, 0.5, 1.0, 1.375]),
        floats("wavelengths", &[4], [400.0, 500.0, 600.0, 700.0]),
        pattern("ndf", &[3, 6], 7, 0.5, 4.5),
        floats("sigma", &[2, 5], sigma.into_iter().chain(sigma)),
        pattern("vndf", &[1, 4, 5, 4], 13, 0.25, 2.25),
        pattern("luminance", &[1, 4, 8, 8], 5, 0.5, 1.5),
        pattern("spectra", &[1, 4, 4, 8, 8], 29, 0.125, 2.125),
        Field("jacobian", 1, vec![1], vec![1]),
    ]
}
