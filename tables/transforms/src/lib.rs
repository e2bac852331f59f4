//! Plans of Fourier transforms.
//!
//! A crate that makes a plan compiles all algorithms of rustfft for its numbers, which takes a
//! minute of the processor. So plans are made here, once for the whole project. They are kept and
//! shared. No transform is divided by its length.

use std::sync::{Arc, LazyLock, Mutex, PoisonError};

use realfft::RealFftPlanner;
pub use realfft::{ComplexToReal, RealToComplex};
use rustfft::FftPlanner;
pub use rustfft::{Fft, FftNum};

/// Numbers in which transforms are computed: `f32` and `f64`.
pub trait Real: FftNum {
    /// Plans the transform of `length` real numbers to the frequencies 0 to `length` / 2.
    fn forward(length: usize) -> Arc<dyn RealToComplex<Self>>;
    /// Plans the inverse of [`Real::forward`], to `length` real numbers.
    fn inverse(length: usize) -> Arc<dyn ComplexToReal<Self>>;
    /// Plans the transform of `length` complex numbers.
    fn complex_forward(length: usize) -> Arc<dyn Fft<Self>>;
    /// Plans the inverse of [`Real::complex_forward`].
    fn complex_inverse(length: usize) -> Arc<dyn Fft<Self>>;
}

macro_rules! planned {
    ($number:ty) => {
        const _: () = {
            type Planners = (RealFftPlanner<$number>, FftPlanner<$number>);
            static PLANNERS: LazyLock<Mutex<Planners>> =
                LazyLock::new(|| Mutex::new((RealFftPlanner::new(), FftPlanner::new())));

            fn with<T>(plan: impl FnOnce(&mut Planners) -> T) -> T {
                plan(&mut PLANNERS.lock().unwrap_or_else(PoisonError::into_inner))
            }

            impl Real for $number {
                #[inline(never)]
                fn forward(length: usize) -> Arc<dyn RealToComplex<$number>> {
                    with(|(real, _)| real.plan_fft_forward(length))
                }

                #[inline(never)]
                fn inverse(length: usize) -> Arc<dyn ComplexToReal<$number>> {
                    with(|(real, _)| real.plan_fft_inverse(length))
                }

                #[inline(never)]
                fn complex_forward(length: usize) -> Arc<dyn Fft<$number>> {
                    with(|(_, complex)| complex.plan_fft_forward(length))
                }

                #[inline(never)]
                fn complex_inverse(length: usize) -> Arc<dyn Fft<$number>> {
                    with(|(_, complex)| complex.plan_fft_inverse(length))
                }
            }
        };
    };
}
planned!(f32);
planned!(f64);
