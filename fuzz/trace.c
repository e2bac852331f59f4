/* Called by C code compiled with -fsanitize-coverage=trace-pc; libFuzzer reads the counters. Its own function of that name
   only refuses, so that the linker leads the calls here (--wrap). */
#include <stdint.h>

static uint8_t counters[1 << 16] __attribute__((section("__libfuzzer_extra_counters"), used));

__attribute__((no_sanitize_coverage)) void __wrap___sanitizer_cov_trace_pc(void) {
    uintptr_t pc = (uintptr_t)__builtin_return_address(0);
    counters[(pc ^ (pc >> 16)) & 0xffff]++;
}
