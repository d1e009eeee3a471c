// Numbers of W walkers side by side, and what is done to them: the operations of jaxwalk/kernels/graph.py.
//
// W is 16 (AVX-512), 8 (AVX2), 4 (NEON, SSE) or 1 (anything else). F, I and U are W numbers, B is W truth
// values. What JAX defines at the edges (not-a-number in min and max, floats beyond the integers' range) holds.
#pragma once
#ifndef W
#if defined(__AVX512F__)
#define W 16
#elif defined(__AVX2__)
#define W 8
#elif defined(__aarch64__) || defined(__SSE2__)
#define W 4
#else
#define W 1
#endif
#endif
#include <cmath>
#include <cstdint>
#include <cstring>

#define ALWAYS static inline __attribute__((always_inline))

#if W == 1
typedef float F;
typedef int32_t I;
typedef uint32_t U;
#else
typedef float F __attribute__((vector_size(4 * W), may_alias));
typedef int32_t I __attribute__((vector_size(4 * W), may_alias));
typedef uint32_t U __attribute__((vector_size(4 * W), may_alias));
#endif

ALWAYS F f(float x) { return x - F{}; }  // -0 stays what it is
ALWAYS I i(int32_t x) { return I{} + x; }
ALWAYS U u(uint32_t x) { return U{} + x; }

template <typename To, typename From> ALWAYS To bits(From x) {
  static_assert(sizeof(To) == sizeof(From));
  To result;
  memcpy(&result, &x, sizeof result);
  return result;
}

// What has no vector form, a walker at a time.
template <typename V, typename G> ALWAYS V each(G of, V a, V b) {
#if W == 1
  return of(a, b);
#else
  V result = a;
  for (int k = 0; k < W; k++) result[k] = of(a[k], b[k]);
  return result;
#endif
}

#if W == 16 && defined(__AVX512F__)
#include <immintrin.h>
typedef __mmask16 B;
#define COMPARE(name, how, signed_how)                                                            \
  ALWAYS B name(F a, F b) { return _mm512_cmp_ps_mask((__m512)a, (__m512)b, how); }               \
  ALWAYS B name(I a, I b) { return _mm512_cmp_epi32_mask((__m512i)a, (__m512i)b, signed_how); }   \
  ALWAYS B name(U a, U b) { return _mm512_cmp_epu32_mask((__m512i)a, (__m512i)b, signed_how); }
COMPARE(lt, _CMP_LT_OQ, _MM_CMPINT_LT)
COMPARE(le, _CMP_LE_OQ, _MM_CMPINT_LE)
COMPARE(gt, _CMP_GT_OQ, _MM_CMPINT_NLE)
COMPARE(ge, _CMP_GE_OQ, _MM_CMPINT_NLT)
COMPARE(eq, _CMP_EQ_OQ, _MM_CMPINT_EQ)
COMPARE(ne, _CMP_NEQ_UQ, _MM_CMPINT_NE)
ALWAYS B truth(bool x) { return x ? 0xffff : 0; }
ALWAYS B both(B a, B b) { return a & b; }
ALWAYS B either(B a, B b) { return a | b; }
ALWAYS B unlike(B a, B b) { return a ^ b; }
ALWAYS B opposite(B a) { return ~a; }
ALWAYS bool any(B a) { return a; }
ALWAYS F select(B which, F no, F yes) { return (F)_mm512_mask_blend_ps(which, (__m512)no, (__m512)yes); }
ALWAYS I select(B which, I no, I yes) { return (I)_mm512_mask_blend_epi32(which, (__m512i)no, (__m512i)yes); }
ALWAYS U select(B which, U no, U yes) { return (U)_mm512_mask_blend_epi32(which, (__m512i)no, (__m512i)yes); }
ALWAYS I integer(B a) { return (I)_mm512_maskz_set1_epi32(a, 1); }
ALWAYS F root(F x) { return (F)_mm512_sqrt_ps((__m512)x); }
// The instruction gives b where either is not a number.
ALWAYS F least(F a, F b) {
  return (F)_mm512_mask_mov_ps(_mm512_min_ps((__m512)a, (__m512)b), ne(a, a), (__m512)a);
}
ALWAYS F greatest(F a, F b) {
  return (F)_mm512_mask_mov_ps(_mm512_max_ps((__m512)a, (__m512)b), ne(a, a), (__m512)a);
}
// b is a number.
ALWAYS F least_known(F a, float b) { return (F)_mm512_min_ps((__m512)f(b), (__m512)a); }
ALWAYS F greatest_known(F a, float b) { return (F)_mm512_max_ps((__m512)f(b), (__m512)a); }
#else
#if W == 1
typedef int32_t B;  // 0 or -1
#define TRUTH(x) (-(x))
#else
typedef I B;  // 0 or -1
#define TRUTH(x) ((I)(x))
#if W == 8 && defined(__AVX__)
#include <immintrin.h>
#endif
#if W == 4 && defined(__aarch64__)
#include <arm_neon.h>
#endif
#endif
#define COMPARE(name, sign)                                    \
  ALWAYS B name(F a, F b) { return TRUTH(a sign b); }          \
  ALWAYS B name(I a, I b) { return TRUTH(a sign b); }          \
  ALWAYS B name(U a, U b) { return TRUTH(a sign b); }
COMPARE(lt, <)
COMPARE(le, <=)
COMPARE(gt, >)
COMPARE(ge, >=)
COMPARE(eq, ==)
COMPARE(ne, !=)
ALWAYS B truth(bool x) { return i(-(int)x); }
ALWAYS B both(B a, B b) { return a & b; }
ALWAYS B either(B a, B b) { return a | b; }
ALWAYS B unlike(B a, B b) { return a ^ b; }
ALWAYS B opposite(B a) { return ~a; }
ALWAYS bool any(B a) {
#if W == 1
  return a;
#else
  int32_t found = 0;
  for (int k = 0; k < W; k++) found |= a[k];
  return found;
#endif
}
ALWAYS F select(B which, F no, F yes) { return which ? yes : no; }
ALWAYS I select(B which, I no, I yes) { return which ? yes : no; }
ALWAYS U select(B which, U no, U yes) { return which ? yes : no; }
ALWAYS I integer(B a) { return a & i(1); }
ALWAYS F root(F x) {
#if W == 8 && defined(__AVX__)
  return (F)_mm256_sqrt_ps((__m256)x);
#elif W == 4 && defined(__aarch64__)
  return (F)vsqrtq_f32((float32x4_t)x);
#else
  return each([](float a, float) { return __builtin_sqrtf(a); }, x, x);
#endif
}
// b where it is less, and where a is a number and b is none.
ALWAYS F least(F a, F b) { return select(either(le(a, b), ne(a, a)), b, a); }
ALWAYS F greatest(F a, F b) { return select(either(ge(a, b), ne(a, a)), b, a); }
// b is a number.
ALWAYS F least_known(F a, float b) { return select(gt(a, f(b)), a, f(b)); }
ALWAYS F greatest_known(F a, float b) { return select(lt(a, f(b)), a, f(b)); }
#endif

ALWAYS I least(I a, I b) { return select(lt(b, a), a, b); }
ALWAYS I greatest(I a, I b) { return select(gt(b, a), a, b); }
ALWAYS U least(U a, U b) { return select(lt(b, a), a, b); }
ALWAYS U greatest(U a, U b) { return select(gt(b, a), a, b); }

ALWAYS F magnitude(F x) { return bits<F>(bits<U>(x) & u(0x7fffffff)); }
ALWAYS U magnitude(U x) { return x; }
ALWAYS I magnitude(I x) { return select(lt(x, i(0)), x, -x); }
ALWAYS F negative(F x) { return bits<F>(bits<U>(x) ^ u(0x80000000)); }
ALWAYS I negative(I x) { return -x; }
ALWAYS U negative(U x) { return -x; }
ALWAYS F with_sign(F size, F sign) { return bits<F>(bits<U>(size) | (bits<U>(sign) & u(0x80000000))); }
ALWAYS B finite(F x) { return lt(magnitude(x), f(INFINITY)); }
ALWAYS F sign(F x) { return select(gt(magnitude(x), f(0)), x, with_sign(f(1), x)); }
ALWAYS U sign(U x) { return select(eq(x, u(0)), u(1), u(0)); }
ALWAYS I sign(I x) { return select(gt(x, i(0)), select(lt(x, i(0)), i(0), i(-1)), i(1)); }

// To the nearest whole number, halves to even: beyond 2^23 floats have no fraction.
ALWAYS F rounded(F x) {
  F size = magnitude(x);
  F near = (size + 8388608.0f) - 8388608.0f;
  return select(lt(size, f(8388608.0f)), x, with_sign(near, x));
}
ALWAYS F floored(F x) {
  F near = rounded(x);
  return select(gt(near, x), near, near - 1.0f);
}

#if W == 1
ALWAYS F floating(I x) { return (float)x; }
ALWAYS F floating(U x) { return (float)x; }
ALWAYS I truncated(F x) { return (int32_t)x; }
#else
ALWAYS F floating(I x) { return __builtin_convertvector(x, F); }
ALWAYS F floating(U x) { return __builtin_convertvector(x, F); }
ALWAYS I truncated(F x) { return __builtin_convertvector(x, I); }
#endif
ALWAYS F floating_truth(B x) { return select(x, f(0), f(1)); }
// Towards nought; the nearest there is where there is none, 0 of what is not a number.
ALWAYS I whole(F x) {
  F inside = select(both(ge(x, f(-2147483648.0f)), lt(x, f(2147483648.0f))), f(0), x);
  I result = truncated(inside);
  result = select(ge(x, f(2147483648.0f)), result, i(2147483647));
  return select(lt(x, f(-2147483648.0f)), result, i(-2147483647 - 1));
}
ALWAYS U whole_unsigned(F x) {
  return each([](uint32_t a, uint32_t) {
    float number;
    memcpy(&number, &a, 4);
    return number >= 4294967296.0f ? UINT32_MAX : number > 0 ? (uint32_t)number : 0u;
  }, bits<U>(x), bits<U>(x));
}

// As JAX has them: x / 0 is -1 (all bits), x % 0 is x.
ALWAYS I quotient(I a, I b) {
  return each([](int32_t x, int32_t y) { return y == 0 ? -1 : y == -1 ? (int32_t)(0u - (uint32_t)x) : x / y; }, a, b);
}
ALWAYS U quotient(U a, U b) {
  return each([](uint32_t x, uint32_t y) { return y == 0 ? UINT32_MAX : x / y; }, a, b);
}
ALWAYS F quotient(F a, F b) { return a / b; }
ALWAYS I remainder(I a, I b) {
  return each([](int32_t x, int32_t y) { return y == 0 ? x : y == -1 ? 0 : x % y; }, a, b);
}
ALWAYS U remainder(U a, U b) {
  return each([](uint32_t x, uint32_t y) { return y == 0 ? x : x % y; }, a, b);
}
