/* C code that is compiled with -fsanitize-coverage=trace-pc calls this function at every edge of
   the control flow. libFuzzer reads the counters. libFuzzer has a function of the same name, which
   only reports an error. So the linker redirects the calls to this function (--wrap). */
#include <stdint.h>

static uint8_t counters[1 << 16] __attribute__((section("__libfuzzer_extra_counters"), used));

__attribute__((no_sanitize_coverage)) void __wrap___sanitizer_cov_trace_pc(void) {
    uintptr_t pc = (uintptr_t)__builtin_return_address(0);
    counters[(pc ^ (pc >> 16)) & 0xffff]++;
}
