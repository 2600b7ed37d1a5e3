use super::*;

#[test]
fn a_single_changed_bit_breaks_the_seal() {
    let mut w = Writer::default();
    w.text("text");
    w.f64(-0.0);
    let content = w.clone().into_bytes();
    let sealed = w.seal();
    assert_eq!(unseal(&sealed), Ok(&content[..]));
    for bit in 0..8 * sealed.len() {
        let mut other = sealed.clone();
        other[bit / 8] ^= 1 << (bit % 8);
        assert!(unseal(&other).is_err(), "bit {bit}");
    }
    for end in 0..sealed.len() {
        assert!(unseal(&sealed[..end]).is_err(), "cut at {end}");
    }
}

#[test]
fn what_was_written_is_read_and_what_is_cut_short_is_refused() {
    let mut w = Writer::default();
    w.u32(7);
    w.f64s(&[0.1, f64::NEG_INFINITY]);
    w.text("R, N");
    w.vec3(Vec3::new(1.0, -0.0, f32::MIN_POSITIVE));
    let bytes = w.into_bytes();
    let read = |bytes: &[u8]| -> Result<(u32, [f64; 2], String, Vec3), String> {
        let mut r = Reader::new(bytes);
        let all = (r.u32()?, r.f64s()?, r.text()?.to_string(), r.vec3()?);
        r.end()?;
        Ok(all)
    };
    let (a, b, c, d) = read(&bytes).expect("what was written");
    assert_eq!((a, b, c.as_str()), (7, [0.1, f64::NEG_INFINITY], "R, N"));
    assert_eq!(d.to_array().map(f32::to_bits)[1], (-0.0f32).to_bits());
    for n in 0..bytes.len() {
        assert!(read(&bytes[..n]).is_err(), "cut at {n}");
    }
    assert!(read(&[bytes.as_slice(), &[0]].concat()).is_err());
    // A length that no file has.
    let mut huge = Writer::default();
    huge.u64(u64::MAX);
    assert!(Reader::new(&huge.into_bytes()).bytes().is_err());
}
