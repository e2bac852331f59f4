//! Choice of the instruction set, and the only file with unsafe code.
//!
//! It compiles [`crate::rays::lanes`] and [`crate::rays::packet`] once per instruction set and
//! calls the best that the processor has.
//!
//! The only unsafe act is the call of a function that was compiled for an instruction set. An
//! [`InstructionSet`] is made only after the processor was asked for it.
#![allow(
    unsafe_code,
    reason = "a function compiled for an instruction set may be called only where it is present"
)]

use crate::rays::bundle::Bundle;
use crate::rays::departures::Departures;
use crate::rays::lanes;
use crate::rays::lanes::Batch;
use crate::rays::packet::{Packet, Way};
use crate::rays::rough;
use crate::rays::rough::Flight;
use crate::rays::tally::Tally;

/// Instruction set that this processor has.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct InstructionSet(Level);

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Level {
    Baseline,
    #[cfg(target_arch = "x86_64")]
    Avx2,
    #[cfg(target_arch = "x86_64")]
    Avx512,
}

impl InstructionSet {
    /// Returns all instruction sets that this processor has, the best last.
    ///
    /// All of them give the same bits.
    pub(crate) fn available() -> Vec<Self> {
        let mut sets = vec![InstructionSet(Level::Baseline)];
        #[cfg(target_arch = "x86_64")]
        {
            if is_x86_feature_detected!("avx2") {
                sets.push(InstructionSet(Level::Avx2));
            }
            let features = [
                is_x86_feature_detected!("avx512f"),
                is_x86_feature_detected!("avx512dq"),
                is_x86_feature_detected!("avx512bw"),
                is_x86_feature_detected!("avx512vl"),
                is_x86_feature_detected!("avx512cd"),
            ];
            if features.iter().all(|&present| present) {
                sets.push(InstructionSet(Level::Avx512));
            }
        }
        sets
    }

    /// Returns the best instruction set that this processor has.
    pub(crate) fn best() -> Self {
        Self::available()
            .last()
            .copied()
            .unwrap_or(InstructionSet(Level::Baseline))
    }

    /// Runs [`Packet::advance`] with this instruction set.
    pub(crate) fn advance(self, packet: &mut Packet, way: &Way, bundle: &mut Bundle) {
        match self.0 {
            Level::Baseline => packet.advance(way, bundle),
            // SAFETY: the value exists, so `available` found the instruction set.
            #[cfg(target_arch = "x86_64")]
            Level::Avx2 => unsafe { advance_avx2(packet, way, bundle) },
            // SAFETY: the value exists, so `available` found the instruction set.
            #[cfg(target_arch = "x86_64")]
            Level::Avx512 => unsafe { advance_avx512(packet, way, bundle) },
        }
    }

    /// Runs [`rough::run`] with this instruction set.
    pub(crate) fn fly(self, flight: &Flight, departures: &mut Departures, tally: &mut Tally) {
        match self.0 {
            Level::Baseline => rough::run(flight, departures, tally),
            // SAFETY: the value exists, so `available` found the instruction set.
            #[cfg(target_arch = "x86_64")]
            Level::Avx2 => unsafe { fly_avx2(flight, departures, tally) },
            // SAFETY: the value exists, so `available` found the instruction set.
            #[cfg(target_arch = "x86_64")]
            Level::Avx512 => unsafe { fly_avx512(flight, departures, tally) },
        }
    }

    /// Runs [`lanes::run`] with this instruction set.
    pub(crate) fn run(self, batch: &Batch, tally: &mut Tally) {
        // All programs of a scene have the same rules.
        let first = batch.programs.first();
        let lossy = first.is_some_and(|program| program.entry.is_some());
        match (batch.exits.is_some(), lossy) {
            (false, false) => self.run_with::<false, false>(batch, tally),
            (true, false) => self.run_with::<true, false>(batch, tally),
            (false, true) => self.run_with::<false, true>(batch, tally),
            (true, true) => self.run_with::<true, true>(batch, tally),
        }
    }

    /// Runs [`lanes::run`]. Each case is a function of its own, so that the plain one has its
    /// registers for itself.
    fn run_with<const RECORD: bool, const LOSSY: bool>(self, batch: &Batch, tally: &mut Tally) {
        match self.0 {
            Level::Baseline => lanes::run::<RECORD, LOSSY>(batch, tally),
            // SAFETY: the value exists, so `available` found the instruction set.
            #[cfg(target_arch = "x86_64")]
            Level::Avx2 => unsafe { avx2::<RECORD, LOSSY>(batch, tally) },
            // SAFETY: the value exists, so `available` found the instruction set.
            #[cfg(target_arch = "x86_64")]
            Level::Avx512 => unsafe { avx512::<RECORD, LOSSY>(batch, tally) },
        }
    }
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
fn avx2<const RECORD: bool, const LOSSY: bool>(batch: &Batch, tally: &mut Tally) {
    lanes::run::<RECORD, LOSSY>(batch, tally);
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f,avx512dq,avx512bw,avx512vl,avx512cd")]
fn avx512<const RECORD: bool, const LOSSY: bool>(batch: &Batch, tally: &mut Tally) {
    lanes::run::<RECORD, LOSSY>(batch, tally);
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
fn fly_avx2(flight: &Flight, departures: &mut Departures, tally: &mut Tally) {
    rough::run(flight, departures, tally);
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f,avx512dq,avx512bw,avx512vl,avx512cd")]
fn fly_avx512(flight: &Flight, departures: &mut Departures, tally: &mut Tally) {
    rough::run(flight, departures, tally);
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
fn advance_avx2(packet: &mut Packet, way: &Way, bundle: &mut Bundle) {
    packet.advance(way, bundle);
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f,avx512dq,avx512bw,avx512vl,avx512cd")]
fn advance_avx512(packet: &mut Packet, way: &Way, bundle: &mut Bundle) {
    packet.advance(way, bundle);
}
