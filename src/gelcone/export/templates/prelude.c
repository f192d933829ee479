#include <float.h>
#include <math.h>
#include <stdint.h>
#include <string.h>

#if defined(__FAST_MATH__)
#error "compile without -ffast-math: it changes the numbers"
#endif
#if defined(FLT_EVAL_METHOD) && FLT_EVAL_METHOD > 0
#error "doubles must be rounded to doubles; on 32-bit x86 give -msse2 -mfpmath=sse"
#endif
#if defined(_MSC_VER)
#pragma fp_contract(off)
#elif defined(__clang__)
#pragma STDC FP_CONTRACT OFF
#endif

typedef void (*function)(void);
typedef DEVICE_word word;
typedef DEVICE_state state;
typedef DEVICE instance;
