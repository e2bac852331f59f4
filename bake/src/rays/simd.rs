//! Choice of the instruction set, and the only file with unsafe code.
//!
//! It compiles a [`Task`] once per instruction set and calls the best that the processor has.
//!
//! There are two unsafe acts. One is the call of a function that was compiled for an instruction
//! set: an [`InstructionSet`] is made only after the processor was asked for it. The other asks for
//! memory ahead of its use, which reads no value.
#![allow(
    unsafe_code,
    reason = "a function compiled for an instruction set may be called only where it is present"
)]

/// Work that is compiled for each instruction set.
pub(crate) trait Task {
    /// Result of the work.
    type Output;

    /// Does the work.
    ///
    /// Each implementation is marked `#[inline(always)]`, and so are the functions that it calls.
    /// Code that is not inlined is compiled for the baseline.
    fn run(self) -> Self::Output;
}

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

    /// Runs `task` with this instruction set.
    #[inline(always)]
    pub(crate) fn run<T: Task>(self, task: T) -> T::Output {
        match self.0 {
            Level::Baseline => task.run(),
            // SAFETY: the value exists, so `available` found the instruction set.
            #[cfg(target_arch = "x86_64")]
            Level::Avx2 => unsafe { avx2(task) },
            // SAFETY: the value exists, so `available` found the instruction set.
            #[cfg(target_arch = "x86_64")]
            Level::Avx512 => unsafe { avx512(task) },
        }
    }
}

/// Brings `value` into the caches ahead of its use. No result depends on it.
#[inline(always)]
pub(crate) fn fetch<T>(value: &T) {
    #[cfg(target_arch = "x86_64")]
    {
        use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
        let start = std::ptr::from_ref(value).cast::<i8>();
        for byte in (0..size_of::<T>()).step_by(CACHE_LINE) {
            // SAFETY: the address is that of a byte of `value`, and a prefetch reads no value. SSE
            // is part of every x86-64.
            unsafe { _mm_prefetch::<_MM_HINT_T0>(start.add(byte)) };
        }
    }
    #[cfg(not(target_arch = "x86_64"))]
    let _ = value;
}

/// Size of a line of the caches, bytes.
#[cfg(target_arch = "x86_64")]
const CACHE_LINE: usize = 64;

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
fn avx2<T: Task>(task: T) -> T::Output {
    task.run()
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f,avx512dq,avx512bw,avx512vl,avx512cd")]
fn avx512<T: Task>(task: T) -> T::Output {
    task.run()
}
