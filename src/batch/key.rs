//! The name of a result: what it depends on, as one number.

use sha2::{Digest, Sha256};

/// The SHA-256, in hexadecimal, of the pieces that a result depends on, each with its length before it.
///
/// ```
/// use amcheck::batch::key;
/// assert_eq!(key(&[b"ab", b"c"]).len(), 64);
/// assert_ne!(key(&[b"ab", b"c"]), key(&[b"a", b"bc"]));
/// ```
pub fn key(pieces: &[&[u8]]) -> String {
    let mut hash = Sha256::new();
    for piece in pieces {
        hash.update((piece.len() as u64).to_le_bytes());
        hash.update(piece);
    }
    hex(&hash.finalize())
}

/// Bytes as hexadecimal digits.
pub(super) fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|b| format!("{b:02x}")).collect()
}
