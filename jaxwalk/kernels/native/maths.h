// Elementary functions of W walkers, to about a unit in the last place. Reductions and polynomials after
// Moshier's Cephes library, single precision; powers, remainders and far angles are the C library's.
#pragma once
#include "lanes.h"

// a + b x and so on, highest power first.
template <typename... T> ALWAYS F polynomial(F x, float first, T... rest) {
  F total = f(first);
  ((total = total * x + rest), ...);
  return total;
}

ALWAYS F exponential(F x) {
  F in = select(gt(x, f(88.8f)), select(lt(x, f(-104.0f)), x, f(-104.0f)), f(88.8f));
  F n = rounded(in * 1.44269504f);
  F r = in - n * 0.693359375f;
  r = r - n * -2.12194440e-4f;
  F value = polynomial(r, 1.9875691500e-4f, 1.3981999507e-3f, 8.3334519073e-3f, 4.1665795894e-2f,
                       1.6666665459e-1f, 5.0000001201e-1f) * (r * r) + r + 1.0f;
  // In two steps: the power of two may itself be none that a float can hold.
  I power = truncated(select(eq(n, n), f(0), n));
  I half = power >> 1;
  value = value * bits<F>((half + 127) << 23) * bits<F>((power - half + 127) << 23);
  return select(eq(x, x), x, value);
}

// log(1 + x) of 1 + x >= 0, by log(m) + e log(2) with m in [sqrt(1/2), sqrt(2)].
ALWAYS F log_of_one_more(F x) {
  F one_more = 1.0f + x;
  I raw = bits<I>(one_more);
  I exponent = ((raw - 0x3f3504f3) >> 23);
  F mantissa = bits<F>(raw - (exponent << 23));
  F e = floating(exponent);
  F near = mantissa - 1.0f;
  F square = near * near;
  F value = near * square * polynomial(near, 7.0376836292e-2f, -1.1514610310e-1f, 1.1676998740e-1f,
                                       -1.2420140846e-1f, 1.4249322787e-1f, -1.6668057665e-1f,
                                       2.0000714765e-1f, -2.4999993993e-1f, 3.3333331174e-1f);
  value = value + e * -2.12194440e-4f - 0.5f * square;
  value = near + value + e * 0.693359375f;
  // What 1 + x has lost of x.
  F lost = x - (one_more - 1.0f);
  value = value + lost / one_more;
  value = select(lt(magnitude(x), f(1e-5f)), value, x - 0.5f * x * x);
  value = select(eq(one_more, f(0)), value, f(-INFINITY));
  value = select(eq(x, f(INFINITY)), value, x);
  return select(ge(one_more, f(0)), f(NAN), value);
}

struct Turned { F sine, cosine; };

// Sine and cosine of what is left of x when whole quarters of a turn are taken off, and how many these are.
ALWAYS Turned turned(F x, I *quarters) {
  F n = rounded(x * 0.636619772f);
  F r = x - n * 1.5703125f;
  r = r - n * 4.837512969970703125e-4f;
  r = r - n * 7.54978995489188216e-8f;
  F z = r * r;
  *quarters = truncated(n);
  return {polynomial(z, -1.9515295891e-4f, 8.3321608736e-3f, -1.6666654611e-1f) * z * r + r,
          polynomial(z, 2.443315711809948e-5f, -1.388731625493765e-3f, 4.166664568298827e-2f) * z * z -
              0.5f * z + 1.0f};
}

static const float FAR = 8192.0f;  // of angles; beyond it the C library's own functions are asked

__attribute__((noinline, cold)) static F far_sine(F x) {
  return each([](float a, float) { return sinf(a); }, x, x);
}
__attribute__((noinline, cold)) static F far_cosine(F x) {
  return each([](float a, float) { return cosf(a); }, x, x);
}

ALWAYS F quarter_sine(F x, int ahead) {
  B far = opposite(le(magnitude(x), f(FAR)));
  I quarters;
  Turned t = turned(select(far, x, f(0)), &quarters);
  quarters = quarters + ahead;
  F value = select(ne(quarters & i(1), i(0)), t.sine, t.cosine);
  return bits<F>(bits<U>(value) ^ (bits<U>(quarters & i(2)) << 30));
}

ALWAYS F sine(F x) {
  F value = quarter_sine(x, 0);
  B far = opposite(le(magnitude(x), f(FAR)));
  if (__builtin_expect(any(far), 0)) value = select(far, value, far_sine(x));
  return value;
}

ALWAYS F cosine(F x) {
  F value = quarter_sine(x, 1);
  B far = opposite(le(magnitude(x), f(FAR)));
  if (__builtin_expect(any(far), 0)) value = select(far, value, far_cosine(x));
  return value;
}

ALWAYS F arcsine(F x) {
  F size = magnitude(x);
  B near = le(size, f(0.5f));
  F z = select(near, 0.5f * (1.0f - size), size * size);
  F base = select(near, root(z), size);
  F value = polynomial(z, 4.2163199048e-2f, 2.4181311049e-2f, 4.5470025998e-2f, 7.4953002686e-2f,
                       1.6666752422e-1f) * z * base + base;
  return with_sign(select(near, 1.57079637f - (value + value), value), x);
}

// Of y / x, in the quadrant that their signs tell.
ALWAYS F arctangent(F y, F x) {
  F a = magnitude(x), b = magnitude(y);
  B steep = gt(b, a);
  F low = select(steep, b, a), high = select(steep, a, b);
  F ratio = low / high;
  ratio = select(eq(high, f(0)), ratio, f(0));
  ratio = select(eq(low, f(INFINITY)), ratio, f(1));
  // tan(pi / 8): from there on the angle is taken from pi / 4.
  B wide = gt(ratio, f(0.414213562f));
  F near = select(wide, ratio, (ratio - 1.0f) / (ratio + 1.0f));
  F z = near * near;
  F value = polynomial(z, 8.05374449538e-2f, -1.38776856032e-1f, 1.99777106478e-1f, -3.33329491539e-1f) *
                z * near + near;
  value = select(wide, value, value + 0.785398163f);
  value = select(steep, value, 1.57079637f - value);
  value = select(ne(bits<U>(x) & u(0x80000000), u(0)), value, 3.14159274f - value);
  value = with_sign(value, y);
  value = select(ne(x, x), value, x);
  return select(ne(y, y), value, y);
}

ALWAYS F power(F x, F y) {
  return each([](float a, float b) { return powf(a, b); }, x, y);
}
ALWAYS F remainder(F x, F y) {
  return each([](float a, float b) { return fmodf(a, b); }, x, y);
}
