//! One tile as bytes, exact to the last bit.
//!
//! Little-endian: the mark `TILE`, its number, its pixels; rays and seven counts as u64; for each pixel, row by row, eleven words (colour,
//! depth, normal, primitive, material, box tests, primitive tests; floats by their bits); CRC-32 of all that.

use std::io::{self, ErrorKind, Read};

use boxwood::Counts;

use crate::{Crop, Film, TileWork};

const MARK: [u8; 4] = *b"TILE";
/// Mark, number, pixels.
const HEAD: usize = 12;
/// Rays and counts.
const COUNTERS: usize = 8 * 8;
const PIXEL: usize = 11 * 4;
const CRC: usize = 4;

/// The record of a tile that lies on `film`.
pub(super) fn encode(film: &Film, tile: &TileWork) -> Vec<u8> {
    let pixels = film.tile_pixels(tile.number);
    let mut bytes = Vec::with_capacity(HEAD + COUNTERS + pixels.len() * PIXEL + CRC);
    bytes.extend(MARK);
    bytes.extend(tile.number.to_le_bytes());
    bytes.extend((pixels.len() as u32).to_le_bytes());
    for counter in counters(tile) {
        bytes.extend(counter.to_le_bytes());
    }
    for pixel in pixels {
        for word in film.words(pixel) {
            bytes.extend(word.to_le_bytes());
        }
    }
    bytes.extend(crc32fast::hash(&bytes).to_le_bytes());
    bytes
}

/// One that was read, and is whole.
pub(super) struct Record {
    pub(super) number: u32,
    bytes: Vec<u8>,
}

/// Why there is no record.
pub(super) enum Flaw {
    /// The file ends within it, or holds nothing but zeros from here on, as a power cut leaves it: nothing follows.
    Torn,
    /// Its bits have changed. It has so many bytes, and the next record follows.
    Damaged(u64),
    /// Its head tells no size: what follows is out of reach.
    Lost,
    /// The system does not give it.
    Io(io::Error),
}

impl Record {
    /// The next of `file`, of a film of this window; none at the end.
    pub(super) fn read(file: &mut impl Read, window: Crop) -> Result<Option<Self>, Flaw> {
        let mut bytes = vec![0; HEAD];
        let got = read_up_to(file, &mut bytes).map_err(Flaw::Io)?;
        if got == 0 {
            return Ok(None);
        }
        if bytes[..got.min(4)] != MARK[..got.min(4)] {
            let zeros = bytes[..got].iter().all(|&byte| byte == 0) && only_zeros(file)?;
            return Err(if zeros { Flaw::Torn } else { Flaw::Lost });
        }
        if got < HEAD {
            return Err(Flaw::Torn);
        }
        let (number, pixels) = (word(&bytes, 4), word(&bytes, 8) as usize);
        let exists = (number as usize) < window.tile_count();
        if !exists || window.tile(number).area() != pixels as u64 {
            return Err(Flaw::Lost);
        }
        bytes.resize(HEAD + COUNTERS + pixels * PIXEL + CRC, 0);
        let rest = &mut bytes[HEAD..];
        if read_up_to(file, rest).map_err(Flaw::Io)? < rest.len() {
            return Err(Flaw::Torn);
        }
        let end = bytes.len() - CRC;
        match crc32fast::hash(&bytes[..end]) == word(&bytes, end) {
            true => Ok(Some(Self { number, bytes })),
            false => Err(Flaw::Damaged(bytes.len() as u64)),
        }
    }

    /// In the file.
    pub(super) fn len(&self) -> u64 {
        self.bytes.len() as u64
    }

    /// Onto the film, whose counts grow by it. Says whether the tile was not there yet: one that is there twice counts once.
    pub(super) fn lay_down(&self, film: &mut Film) -> bool {
        if std::mem::replace(&mut film.finished[self.number as usize], true) {
            return false;
        }
        let counter = |k: usize| {
            let at = HEAD + 8 * k;
            u64::from(word(&self.bytes, at)) | u64::from(word(&self.bytes, at + 4)) << 32
        };
        film.rays = film.rays.saturating_add(counter(0));
        film.add_counts(std::array::from_fn(|k| counter(k + 1)));
        let pixels = film.tile_pixels(self.number).into_iter();
        for (pixel, at) in pixels.zip((HEAD + COUNTERS..).step_by(PIXEL)) {
            let words = std::array::from_fn(|k| word(&self.bytes, at + 4 * k));
            film.set_words(pixel, words);
        }
        true
    }
}

fn counters(tile: &TileWork) -> [u64; 8] {
    let Counts {
        rays,
        nodes,
        boxes,
        prims,
        instances,
        flops,
        bytes,
    } = tile.counts;
    [
        tile.rays, rays, nodes, boxes, prims, instances, flops, bytes,
    ]
}

fn word(bytes: &[u8], at: usize) -> u32 {
    u32::from_le_bytes([bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]])
}

/// Whether nothing else follows.
fn only_zeros(file: &mut impl Read) -> Result<bool, Flaw> {
    let mut bytes = [0; 4096];
    loop {
        match read_up_to(file, &mut bytes).map_err(Flaw::Io)? {
            0 => return Ok(true),
            got if bytes[..got].iter().any(|&byte| byte != 0) => return Ok(false),
            _ => {}
        }
    }
}

/// As many bytes as there are, up to all.
fn read_up_to(file: &mut impl Read, bytes: &mut [u8]) -> io::Result<usize> {
    let mut got = 0;
    while got < bytes.len() {
        match file.read(&mut bytes[got..]) {
            Ok(0) => break,
            Ok(n) => got += n,
            Err(error) if error.kind() == ErrorKind::Interrupted => {}
            Err(error) => return Err(error),
        }
    }
    Ok(got)
}

impl Film {
    /// Where in the layers the pixels of a tile lie, row by row.
    fn tile_pixels(&self, number: u32) -> Vec<usize> {
        let window = self.tile_window(number);
        let row = |y| (window.x..window.x + window.width).map(move |x| (x, y));
        (window.y..window.y + window.height)
            .flat_map(row)
            .map(|(x, y)| self.index(x, y))
            .collect()
    }

    /// All layers at a pixel.
    fn words(&self, pixel: usize) -> [u32; 11] {
        let [r, g, b] = self.color[pixel].map(f32::to_bits);
        let [x, y, z] = self.normal[pixel].map(f32::to_bits);
        let depth = self.depth[pixel].to_bits();
        let (prim, material) = (self.prim[pixel], self.material[pixel]);
        let (boxes, prims) = (self.box_tests[pixel], self.prim_tests[pixel]);
        [r, g, b, depth, x, y, z, prim, material, boxes, prims]
    }

    fn set_words(&mut self, pixel: usize, words: [u32; 11]) {
        let [r, g, b, depth, x, y, z, prim, material, boxes, prims] = words;
        self.color[pixel] = [r, g, b].map(f32::from_bits);
        self.depth[pixel] = f32::from_bits(depth);
        self.normal[pixel] = [x, y, z].map(f32::from_bits);
        (self.prim[pixel], self.material[pixel]) = (prim, material);
        (self.box_tests[pixel], self.prim_tests[pixel]) = (boxes, prims);
    }

    /// Rays, nodes, boxes, primitives, instances, operations, bytes. Saturates: a file may claim anything.
    fn add_counts(&mut self, more: [u64; 7]) {
        let counts = &mut self.counts;
        let sums = [
            &mut counts.rays,
            &mut counts.nodes,
            &mut counts.boxes,
            &mut counts.prims,
            &mut counts.instances,
            &mut counts.flops,
            &mut counts.bytes,
        ];
        for (sum, more) in sums.into_iter().zip(more) {
            *sum = sum.saturating_add(more);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Tone;

    fn film() -> Film {
        let window = Crop {
            x: 3,
            y: 5,
            width: 37,
            height: 20,
        };
        let mut film = Film::unexposed(window, [64, 48], Tone::Neutral, 1.0).unwrap();
        for i in 0..film.color.len() {
            let words =
                std::array::from_fn(|k| (i as u32 * 11 + k as u32).wrapping_mul(2_654_435_761));
            film.set_words(i, words);
        }
        film
    }

    fn work(number: u32) -> TileWork {
        TileWork {
            number,
            rays: 1 << 40 | 7,
            counts: Counts {
                boxes: 3,
                bytes: 5,
                ..Counts::default()
            },
        }
    }

    #[test]
    fn every_bit_of_a_tile_comes_back_even_those_of_nan() {
        let film = film();
        let mut copy = Film::unexposed(film.window, film.full_size, film.tone, 1.0).unwrap();
        for number in 0..film.finished.len() as u32 {
            let bytes = encode(&film, &work(number));
            let record = Record::read(&mut &bytes[..], film.window);
            let record = record.ok().flatten().expect("it is whole");
            assert_eq!((record.number, record.len()), (number, bytes.len() as u64));
            record.lay_down(&mut copy);
        }
        for i in 0..film.color.len() {
            assert_eq!(copy.words(i), film.words(i));
        }
        assert!(copy.is_complete());
        assert_eq!((copy.rays, copy.counts.bytes), (6 * (1 << 40 | 7), 30));
    }

    #[test]
    fn each_cut_is_torn_and_each_changed_byte_is_damage() {
        let film = film();
        let bytes = encode(&film, &work(5));
        for cut in 1..bytes.len() {
            let read = Record::read(&mut &bytes[..cut], film.window);
            assert!(matches!(read, Err(Flaw::Torn)), "cut at {cut}");
        }
        for at in 0..bytes.len() {
            let mut changed = bytes.clone();
            changed[at] ^= 0x10;
            let read = Record::read(&mut &changed[..], film.window);
            match read {
                Err(Flaw::Lost) => assert!(at < HEAD, "byte {at}"),
                Err(Flaw::Damaged(length)) => {
                    assert!(at >= HEAD && length == bytes.len() as u64, "byte {at}");
                }
                _ => panic!("byte {at}"),
            }
        }
        for length in [1, 12, 10_000] {
            let mut zeros = vec![0; length];
            let read = Record::read(&mut &zeros[..], film.window);
            assert!(matches!(read, Err(Flaw::Torn)), "{length} zeros");
            zeros.push(1);
            let read = Record::read(&mut &zeros[..], film.window);
            assert!(matches!(read, Err(Flaw::Lost)), "{length} zeros and a one");
        }
        assert!(matches!(Record::read(&mut &[][..], film.window), Ok(None)));
    }
}
