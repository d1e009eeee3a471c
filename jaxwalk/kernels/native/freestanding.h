// What lanes.h and maths.h want of the C library, where there is none: a few functions of whoever loads the
// program, and the compiler's own.
#pragma once
#include <stdint.h>
#define INFINITY __builtin_inff()
#define NAN __builtin_nanf("")
#define memcpy __builtin_memcpy
extern "C" {
float sinf(float);
float cosf(float);
float powf(float, float);
float fmodf(float, float);
}
