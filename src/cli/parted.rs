//! Columns with gaps, in Parquet's encoding.

/// What is there, and for every place whether something is (1) or not (0).
pub fn parted<T>(values: impl Iterator<Item = Option<T>>) -> (Vec<T>, Vec<i16>) {
    let (mut found, mut there) = (Vec::new(), Vec::new());
    for value in values {
        there.push(i16::from(value.is_some()));
        found.extend(value);
    }
    (found, there)
}
