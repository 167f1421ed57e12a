/* Which of its own functions this processor can run, and which texts the library was made of: `native/build.py`. */
#include "mcdas.h"

PUBLIC whole mcdas_digest(void) { return DIGEST; }

/* of x86-64's levels, as its psABI numbers them; 1 everywhere else */
PUBLIC int mcdas_level(void)
{
#if defined(__x86_64__) && defined(__GNUC__)
    __builtin_cpu_init();
    if (!(__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") && __builtin_cpu_supports("bmi2"))) return 1;
    if (!(__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512cd"))) return 3;
    return __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl") ? 4 : 3;
#else
    return 1;
#endif
}
