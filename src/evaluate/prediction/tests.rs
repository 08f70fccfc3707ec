use super::*;

const SIZE: Size = Size { width: 4, height: 3 };

/// What every encoding below holds: a hole at (1, 2), a negative value at (2, 0) where the encoding knows signs.
fn values() -> Vec<f64> {
    let mut v: Vec<f64> = (0..12).map(|i| f64::from(i) * 0.25 + 1.0).collect();
    v[9] = f64::NAN;
    v
}

fn same(a: &[f64], b: &[f64]) -> bool {
    a.len() == b.len() && a.iter().zip(b).all(|(x, y)| x == y || (x.is_nan() && y.is_nan()))
}

fn pfm(big: bool) -> Vec<u8> {
    let mut out = format!("Pf\n4 3\n{}\n", if big { "1.0" } else { "-1.0" }).into_bytes();
    for row in values().chunks(4).rev() {
        for x in row {
            let x = *x as f32;
            out.extend(if big { x.to_be_bytes() } else { x.to_le_bytes() });
        }
    }
    out
}

fn npy(version: u8, descr: &str, order: &str, shape: &str, data: &[u8]) -> Vec<u8> {
    let header = format!("{{'descr': '{descr}', 'fortran_order': {order}, 'shape': {shape}, }}\n");
    let mut out = b"\x93NUMPY".to_vec();
    out.extend([version, 0]);
    if version == 1 {
        out.extend((header.len() as u16).to_le_bytes());
    } else {
        out.extend((header.len() as u32).to_le_bytes());
    }
    out.extend(header.bytes());
    out.extend(data);
    out
}

fn f8() -> Vec<u8> {
    values().iter().flat_map(|x| x.to_le_bytes()).collect()
}

fn png16() -> Vec<u8> {
    let mut out = Vec::new();
    let mut encoder = ::png::Encoder::new(&mut out, 4, 3);
    encoder.set_color(::png::ColorType::Grayscale);
    encoder.set_depth(::png::BitDepth::Sixteen);
    let raw = values().into_iter().flat_map(|x| if x.is_nan() { [0, 0] } else { ((x * 256.0) as u16).to_be_bytes() });
    encoder.write_header().unwrap().write_image_data(&raw.collect::<Vec<u8>>()).unwrap();
    out
}

fn tif() -> Vec<u8> {
    use crate::dataset::formats::{Pixels, Plane};
    let pixels = Pixels::Float(values().into_iter().map(|x| x as f32).collect());
    Plane { width: 4, height: 3, pixels }.encode().unwrap()
}

/// Every encoding, by extension.
fn files() -> Vec<(&'static str, Vec<u8>)> {
    vec![
        ("pfm", pfm(false)),
        ("pfm", pfm(true)),
        ("npy", npy(1, "<f8", "False", "(3, 4)", &f8())),
        ("npy", npy(2, "<f8", "False", "(1, 1, 3, 4)", &f8())),
        ("npy", npy(3, "<f8", "False", "(3, 4, 1)", &f8())),
        ("png", png16()),
        ("tif", tif()),
        ("tiff", tif()),
    ]
}

fn read_bytes(extension: &str, bytes: &[u8]) -> Result<Vec<f64>, PredictionError> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(format!("x.{extension}"));
    fs::write(&path, bytes).unwrap();
    read(&path, SIZE, 256.0)
}

#[test]
fn every_encoding_reads_back() {
    for (extension, bytes) in files() {
        assert!(same(&read_bytes(extension, &bytes).unwrap(), &values()), "{extension}");
    }
}

#[test]
fn numpy_orders_and_types() {
    let columns: Vec<u8> =
        (0..4).flat_map(|u| (0..3).map(move |v| v * 4 + u)).flat_map(|i| values()[i].to_le_bytes()).collect();
    assert!(same(&read_bytes("npy", &npy(1, "<f8", "True", "(3, 4)", &columns)).unwrap(), &values()));
    let big: Vec<u8> = (-6_i16..6).flat_map(|x| (x * 16).to_be_bytes()).collect();
    let whole = read_bytes("npy", &npy(1, ">i2", "False", "(3, 4)", &big)).unwrap();
    assert_eq!((whole[0], whole[11]), (-96.0, 80.0));
    let half: Vec<u8> = (0..12).flat_map(|i| half::f16::from_f32(i as f32 * 0.5).to_le_bytes()).collect();
    assert_eq!(read_bytes("npy", &npy(1, "<f2", "False", "(3, 4)", &half)).unwrap()[11], 5.5);
}

#[test]
fn wrong_files_are_told_in_a_sentence() {
    let told = |extension: &str, bytes: &[u8]| read_bytes(extension, bytes).unwrap_err().to_string();
    let sized = |w: u32, h: u32| format!("Pf\n{w} {h}\n-1\n").into_bytes();
    assert!(told("pfm", &sized(2, 3)).contains("it is 2 x 3 pixels, but the sample has 4 x 3"));
    assert!(told("pfm", &sized(3, 4)).contains("rows and columns look exchanged"));
    assert!(told("pfm", &sized(32, 32)).contains("crop the padding"));
    assert!(told("pfm", b"PF\n4 3\n-1\n").contains("three channels"));
    assert!(told("pfm", b"P5\n4 3\n255\n").contains("no PFM"));
    assert!(told("pfm", b"Pf\n4 3\n0\n").contains("byte order"));
    assert!(told("pfm", b"Pf\n99999999999999999999 3\n-1\n").contains("no PFM"));
    assert!(told("pfm", &pfm(false)[..30]).contains("followed by"));
    assert!(told("npy", &npy(1, "<f8", "False", "(3, 4, 2)", &f8())).contains("its shape is (3, 4, 2)"));
    assert!(told("npy", &npy(1, "<f8", "False", "(12,)", &f8())).contains("its shape is (12)"));
    assert!(told("npy", &npy(1, "|O", "False", "(3, 4)", &f8())).contains("it holds `|O`"));
    assert!(told("npy", &npy(1, "<c8", "False", "(3, 4)", &f8())).contains("floats or whole numbers"));
    assert!(told("npy", &npy(1, "<f4", "False", "(3, 4)", &f8())).contains("96 bytes, but its pixels take 48"));
    assert!(told("npy", b"\x93NUMPY\x02\x00\xff\xff\xff\xff{").contains("header is damaged"));
    assert!(told("npy", &npy(1, "<f8", "False", &"(".repeat(9000), &f8())).contains("header is damaged"));
    assert!(told("png", &pfm(false)).contains("cannot be decoded"));
    assert!(told("tif", b"not a tiff").contains("cannot be decoded"));
    let rgb = crate::dataset::formats::Plane {
        width: 4,
        height: 3,
        pixels: crate::dataset::formats::Pixels::Rgb(vec![0; 36]),
    };
    assert!(told("png", &rgb.encode().unwrap()).contains("one channel of 16 bits"));
    let normals = crate::dataset::formats::Plane {
        width: 4,
        height: 3,
        pixels: crate::dataset::formats::Pixels::Vector(vec![0; 36]),
    };
    assert!(told("tif", &normals.encode().unwrap()).contains("one channel"));
    let small = Size { width: 2, height: 1 };
    assert!(small.expect(1, 1).is_err() && SIZE.expect(u64::MAX, u64::MAX).is_err());
    let half = Size { width: 8, height: 6 }.expect(4, 3).unwrap_err().to_string();
    assert!(half.contains("1/2 of the resolution") && half.contains("multiply its disparities by 2"), "{half}");
    assert!(read(Path::new("/"), SIZE, 256.0).unwrap_err().to_string().contains("no file"));
    assert!(told("pfm", &vec![b' '; (HEADER_ROOM + 4096) as usize]).contains("larger than any map"));
}

/// Whatever a byte is changed to, there are twelve numbers or a sentence.
#[test]
fn no_changed_or_missing_byte_makes_a_reader_panic() {
    for (extension, bytes) in files() {
        let decode = |b: &[u8]| match extension {
            "pfm" => pfm::decode(b, SIZE),
            "npy" => npy::decode(b, SIZE),
            "png" => png::decode(b, SIZE, 256.0),
            _ => tiff::decode(b, SIZE),
        };
        let (mut read, mut refused) = (0, 0);
        for at in 0..bytes.len() {
            assert!(decode(&bytes[..at]).is_err() || extension != "pfm", "{extension} cut to {at}");
            for value in [0, 1, b'(', b'9', 0x7f, 0xff] {
                let mut changed = bytes.clone();
                changed[at] = value;
                match decode(&changed) {
                    Ok(values) => {
                        assert_eq!(values.len(), 12);
                        read += 1;
                    }
                    Err(e) => {
                        assert!(e.to_string().len() < 400 && !e.to_string().contains('\n'), "{e}");
                        refused += 1;
                    }
                }
            }
        }
        assert!(read > 0 && refused > 0, "{extension}: {read} read, {refused} refused");
    }
}

#[test]
fn names_are_found_flat_or_in_folders() {
    let folder = tempfile::tempdir().unwrap();
    fs::create_dir(folder.path().join("city-1")).unwrap();
    for name in [
        "city-1/b00-a00.npy",
        "city-1__b00-a01.tiff",
        "city-1/b00-a02.pfm",
        "city-1__b00-a02.png",
        "odd.npy",
        "log.txt",
    ] {
        fs::write(folder.path().join(name), b"").unwrap();
    }
    let at = |id: &str| find(folder.path(), id);
    assert_eq!(at("city-1/b00-a00"), Found::At("city-1/b00-a00.npy".into()));
    assert_eq!(at("city-1/b00-a01"), Found::At("city-1__b00-a01.tiff".into()));
    assert!(matches!(at("city-1/b00-a02"), Found::Several(paths) if paths.len() == 2));
    assert_eq!(at("city-1/b00-a03"), Found::Missing);
    let known = ["city-1/b00-a00.npy", "city-1__b00-a01.tiff"].map(PathBuf::from).into();
    let names: Vec<_> = strangers(folder.path(), &known).iter().map(|p| p.display().to_string()).collect();
    assert_eq!(names, ["city-1/b00-a02.pfm", "city-1__b00-a02.png", "odd.npy"]);
}
