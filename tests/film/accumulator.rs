//! Deposits are summed exactly: no order, thread or shard can change a bit.

use nephroid::internals::film::accumulator::AccumulatorError;
use nephroid::internals::film::{Accumulator, ReplicateMean};
use nephroid::internals::numeric::{FixedPoint, SampleMoments, Stream, StreamKind};
use proptest::prelude::*;
use rayon::prelude::*;

/// Quanta of 1: integers mean themselves.
fn unit() -> FixedPoint {
    FixedPoint::new(0).unwrap()
}

/// One texel and channel after replicates of given sums.
fn after(replicates: &[i64]) -> Accumulator {
    let mut accumulator = Accumulator::new(1, 1, unit());
    for &sum in replicates {
        assert!(accumulator.deposit(0, [sum]));
        accumulator.flush().unwrap();
    }
    accumulator
}

fn estimate(replicates: &[i64]) -> ReplicateMean {
    after(replicates).estimate(0, 0).unwrap()
}

fn bytes(accumulator: &Accumulator) -> Vec<u8> {
    let mut bytes = Vec::new();
    accumulator.write_to(&mut bytes).unwrap();
    bytes
}

/// Deposit `i` of a replicate: a texel of 64 and three channels' quanta.
fn deposit(stream: &Stream, i: u64) -> (usize, [i64; 3]) {
    let [a, b, c, d] = stream.point4(i);
    let quanta = [b, c, d].map(|x| (x * 2f64.powi(40)) as i64);
    ((a * 64.0) as usize, quanta)
}

/// The bytes of `replicates` numbers of replicates of 10,000 deposits, on `threads` threads.
fn run(replicates: std::ops::Range<u64>, threads: usize, backwards: bool) -> Accumulator {
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .build()
        .unwrap();
    let root = Stream::new(StreamKind::Random, 1);
    let mut accumulator = Accumulator::new(64, 3, unit()).with_counts();
    pool.install(|| {
        for replicate in replicates {
            let stream = root.split(replicate);
            (0..10_000u64).into_par_iter().for_each(|i| {
                let i = if backwards { 9_999 - i } else { i };
                let (texel, quanta) = deposit(&stream, i);
                assert!(accumulator.deposit(texel, quanta));
            });
            accumulator.flush().unwrap();
        }
    });
    accumulator
}

#[test]
fn threads_order_and_shards_change_no_bit() {
    let whole = run(0..6, 1, false);
    let expected = bytes(&whole);
    assert_eq!(bytes(&run(0..6, 4, false)), expected);
    assert_eq!(bytes(&run(0..6, 3, true)), expected);
    let shards = [run(4..6, 2, false), run(0..1, 1, true), run(1..4, 4, false)];
    let mut merged = Accumulator::new(64, 3, unit()).with_counts();
    for shard in &shards {
        let shard = Accumulator::read_from(bytes(shard).as_slice()).unwrap();
        merged.merge(&shard).unwrap();
    }
    assert_eq!(bytes(&merged), expected);
    assert_eq!(merged.replicates(), 6);
    assert_eq!(
        (0..64)
            .map(|texel| merged.count(texel).unwrap())
            .sum::<u64>(),
        60_000
    );
    for texel in 0..64 {
        for channel in 0..3 {
            assert_eq!(
                merged.estimate(texel, channel),
                whole.estimate(texel, channel)
            );
        }
    }
}

#[test]
fn one_deposit_more_changes_the_bytes() {
    // Or the test above could not fail.
    let mut other = run(0..5, 1, false);
    assert!(other.deposit(0, [1, 0, 0]));
    other.flush().unwrap();
    assert_ne!(bytes(&other), bytes(&run(0..6, 1, false)));
}

#[test]
fn every_integer_deposited_arrives() {
    let accumulator = run(0..2, 4, false);
    let root = Stream::new(StreamKind::Random, 1);
    let mut expected = [[0i128; 3]; 64];
    for replicate in 0..2 {
        let stream = root.split(replicate);
        for i in 0..10_000 {
            let (texel, quanta) = deposit(&stream, i);
            for (sum, quanta) in expected[texel].iter_mut().zip(quanta) {
                *sum += i128::from(quanta);
            }
        }
    }
    for (texel, channels) in expected.iter().enumerate() {
        for (channel, &sum) in channels.iter().enumerate() {
            assert_eq!(accumulator.sum(texel, channel), Some(sum));
        }
    }
}

#[test]
fn the_mean_is_correctly_rounded() {
    assert_eq!(estimate(&[1, 0, 0]).mean, 1.0 / 3.0);
    assert_eq!(estimate(&[-7, 0, 0]).mean, -7.0 / 3.0);
    // 2^60 + 1 over 1: rounds down to even; the sum of three has a third in the last place.
    assert_eq!(estimate(&[(1 << 60) + 1]).mean, 2f64.powi(60));
    let scaled = FixedPoint::new(-70).unwrap();
    let mut accumulator = Accumulator::new(1, 1, scaled);
    for sum in [5, 5, 6] {
        assert!(accumulator.deposit(0, [sum]));
        accumulator.flush().unwrap();
    }
    assert_eq!(
        accumulator.estimate(0, 0).unwrap().mean,
        16.0 / 3.0 * 2f64.powi(-70)
    );
}

#[test]
fn equal_replicates_have_an_error_of_exactly_zero_and_nothing_cancels() {
    let large = (1 << 61) + 12345;
    assert_eq!(estimate(&[large; 15]).standard_error, Some(0.0));
    // Deviations ±1 beside 2^61: variance of one replicate 2/3 x ... (R = 3: ((−1)² + 0 + 1²) / 2 = 1),
    // of the mean 1/3. In floating point both sums of squares would be about 2^122.
    let error = estimate(&[large - 1, large, large + 1])
        .standard_error
        .unwrap();
    assert!((error - (1f64 / 3.0).sqrt()).abs() <= 4.0 * f64::EPSILON);
}

#[test]
fn fewer_than_two_replicates_have_no_error_bar() {
    let empty = Accumulator::new(1, 1, unit()).estimate(0, 0).unwrap();
    assert!(empty.mean.is_nan());
    assert_eq!(empty.standard_error, None);
    assert_eq!(
        estimate(&[3]),
        ReplicateMean {
            mean: 3.0,
            standard_error: None
        }
    );
}

#[test]
fn texels_and_channels_outside_are_refused() {
    let accumulator = Accumulator::new(4, 3, unit());
    assert!(!accumulator.deposit(4, [1, 1, 1]));
    assert!(!accumulator.deposit(usize::MAX, [1, 1, 1]));
    assert_eq!(accumulator.estimate(4, 0), None);
    assert_eq!(accumulator.estimate(0, 3), None);
    assert_eq!(accumulator.estimate(usize::MAX, 0), None);
    assert_eq!(accumulator.sum(0, 3), None);
    assert_eq!(accumulator.count(0), None);
}

#[test]
fn overflow_is_an_error_and_the_promised_range_is_not() {
    // Four times the total that the scale is for, on one texel: 2^62 quanta.
    let scale = FixedPoint::for_total(1.0).unwrap();
    let largest = scale.quantise(4.0).unwrap();
    let mut accumulator = Accumulator::new(1, 1, scale);
    for _ in 0..15 {
        assert!(accumulator.deposit(0, [largest]));
        accumulator.flush().unwrap();
    }
    assert_eq!(
        accumulator.estimate(0, 0).unwrap(),
        ReplicateMean {
            mean: 4.0,
            standard_error: Some(0.0)
        }
    );
    assert!(accumulator.deposit(0, [largest]));
    assert!(matches!(
        accumulator.flush(),
        Err(AccumulatorError::Overflow(_))
    ));
    // All light on one texel, as the scale is meant.
    let mut accumulator = Accumulator::new(1, 1, scale);
    for _ in 0..255 {
        assert!(accumulator.deposit(0, [scale.quantise(1.0).unwrap()]));
        accumulator.flush().unwrap();
    }
    // One replicate beyond 63 bits.
    let mut accumulator = Accumulator::new(1, 1, scale);
    assert!(accumulator.deposit(0, [i64::MAX]));
    assert!(accumulator.deposit(0, [1]));
    assert!(matches!(
        accumulator.flush(),
        Err(AccumulatorError::Overflow(_))
    ));
}

#[test]
fn only_sums_of_the_same_things_merge() {
    let mut accumulator = after(&[1, 2]);
    let others = [
        Accumulator::new(2, 1, unit()),
        Accumulator::new(1, 3, unit()),
        Accumulator::new(1, 1, FixedPoint::new(-1).unwrap()),
        Accumulator::new(1, 1, unit()).with_counts(),
    ];
    for other in &others {
        let error = accumulator.merge(other).unwrap_err();
        assert!(
            matches!(error, AccumulatorError::Mismatch { .. }),
            "{error}"
        );
    }
    let under_way = Accumulator::new(1, 1, unit());
    assert!(under_way.deposit(0, [1]));
    let error = accumulator.merge(&under_way).unwrap_err();
    assert!(matches!(error, AccumulatorError::ReplicateUnderWay));
    let error = under_way.write_to(Vec::new()).unwrap_err();
    assert!(matches!(error, AccumulatorError::ReplicateUnderWay));
    assert_eq!(bytes(&accumulator), bytes(&after(&[1, 2])));
}

#[test]
fn damaged_bytes_are_errors() {
    let good = bytes(&run(0..2, 1, false));
    assert!(Accumulator::read_from(good.as_slice()).is_ok());
    for length in (0..good.len()).step_by(97) {
        assert!(
            Accumulator::read_from(&good[..length]).is_err(),
            "cut at {length}"
        );
    }
    let mut errors = 0;
    // Magic bytes and version are compared; a CRC-32 covers the rest.
    for place in (0..200).chain((200..good.len()).step_by(101)) {
        let mut bad = good.clone();
        bad[place] ^= 0x10;
        // Some flips damage nothing: in gzip's time stamp, in codes that deflate never uses.
        if let Ok(read) = Accumulator::read_from(bad.as_slice()) {
            assert_eq!(bytes(&read), good, "byte {place}");
        } else {
            errors += 1;
        }
    }
    assert!(errors > 200);
}

#[test]
fn headers_and_sums_that_cannot_be_are_errors() {
    use std::io::Write;
    // Texels, channels, whether counts follow, exponent, replicates; ΣS and ΣS² of one texel.
    type Parts = (u64, u32, u32, i32, u32, i128, u128);
    let read = |(texels, channels, counts, exponent, replicates, sum, squares): Parts| {
        let mut bytes = bytes(&Accumulator::new(0, 1, unit()))[..8].to_vec();
        let mut encoder = flate2::write::GzEncoder::new(&mut bytes, flate2::Compression::fast());
        encoder.write_all(&texels.to_le_bytes()).unwrap();
        for word in [channels, counts, exponent.cast_unsigned(), replicates] {
            encoder.write_all(&word.to_le_bytes()).unwrap();
        }
        encoder.write_all(&sum.to_le_bytes()).unwrap();
        encoder.write_all(&squares.to_le_bytes()).unwrap();
        encoder.finish().unwrap();
        Accumulator::read_from(bytes.as_slice())
    };
    let good = read((1, 1, 0, 0, 2, -4, 8)).unwrap();
    assert_eq!(
        good.estimate(0, 0),
        Some(ReplicateMean {
            mean: -2.0,
            standard_error: Some(0.0)
        })
    );
    let bad: [(&str, Parts); 8] = [
        ("more texels than sums", (2, 1, 0, 0, 2, -4, 8)),
        ("fewer texels than sums", (0, 1, 0, 0, 2, -4, 8)),
        ("more texels than memory", (u64::MAX, 1, 0, 0, 2, -4, 8)),
        ("two channels", (1, 2, 0, 0, 2, -4, 8)),
        ("a flag of 2", (1, 1, 2, 0, 2, -4, 8)),
        ("an absurd quantum", (1, 1, 0, 5000, 2, -4, 8)),
        ("a negative variance", (1, 1, 0, 0, 2, -4, 7)),
        ("sums without replicates", (1, 1, 0, 0, 0, 0, 8)),
    ];
    for (what, parts) in bad {
        assert!(read(parts).is_err(), "{what}");
    }
}

proptest! {
    #[test]
    fn estimates_agree_with_welford(sums in prop::collection::vec(-1_000_000i64..1_000_000, 2..40)) {
        let expected: SampleMoments = sums.iter().map(|&sum| sum as f64).collect();
        let got = estimate(&sums);
        // Welford's bound is about R ε times the numbers' size, below 2^20 here; the error bar
        // has the variance's relative error, which that size dominates when variance is small.
        let allowed = 40.0 * f64::EPSILON * 2f64.powi(20);
        prop_assert!((got.mean - expected.mean().unwrap()).abs() <= allowed);
        prop_assert!((got.standard_error.unwrap() - expected.standard_error().unwrap()).abs() <= allowed);
    }
}
