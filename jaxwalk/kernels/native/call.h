// How XLA calls a function of walkers: https://openxla.org/xla/custom_call, the interface in C.
//
// Arrays come and go as JAX has them, [walkers, n]. A block of W walkers is turned around on its way into the
// first-level cache, walks there for as many ticks as it is told, and is turned back.
#pragma once
#include "lanes.h"
#include "xla/ffi/api/c_api.h"

enum Kind { NUMBER = 0, FLAG = 1 };  // four bytes, or a truth value's one

struct Array {
  Kind kind;
  int size;          // numbers of one walker
  const int *place;  // of each, which of the block's vectors it is
};

// The numbers of W walkers that lie `apart` in memory, as one vector, and back.
ALWAYS void gather(F *to, const uint32_t *from, int apart) {
#if W == 16 && defined(__AVX512F__)
  const __m512i lanes = _mm512_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15);
  if (apart == 1)
    memcpy(to, from, sizeof *to);
  else
    *to = (F)_mm512_i32gather_epi32(_mm512_mullo_epi32(lanes, _mm512_set1_epi32(apart)), from, 4);
#else
  for (int k = 0; k < W; k++) reinterpret_cast<uint32_t *>(to)[k] = from[k * (int64_t)apart];
#endif
}

ALWAYS void scatter(uint32_t *to, const F *from, int64_t apart) {
  if (apart == 1)
    memcpy(to, from, sizeof *from);
  else
    for (int k = 0; k < W; k++) to[k * apart] = reinterpret_cast<const uint32_t *>(from)[k];
}

static void take(F *block, const Array &array, const void *data, int64_t first, int count) {
  if (array.kind == NUMBER && count == W) {
    const uint32_t *from = static_cast<const uint32_t *>(data) + first * array.size;
    for (int j = 0; j < array.size; j++) gather(block + array.place[j], from + j, array.size);
    return;
  }
  uint32_t *to = reinterpret_cast<uint32_t *>(block);
  for (int j = 0; j < array.size; j++)
    for (int k = 0; k < W; k++) {
      int64_t at = (first + (k < count ? k : count - 1)) * array.size + j;  // the last one once more
      to[array.place[j] * W + k] =
          array.kind == FLAG ? static_cast<const uint8_t *>(data)[at] : static_cast<const uint32_t *>(data)[at];
    }
}

// Into row `at` of `rows` for each walker.
static void give(const F *block, const Array &array, void *data, int64_t first, int count, int64_t rows,
                 int64_t at) {
  if (array.kind == NUMBER && count == W) {
    uint32_t *to = static_cast<uint32_t *>(data) + (first * rows + at) * array.size;
    for (int j = 0; j < array.size; j++) scatter(to + j, block + array.place[j], rows * array.size);
    return;
  }
  const uint32_t *from = reinterpret_cast<const uint32_t *>(block);
  for (int j = 0; j < array.size; j++)
    for (int k = 0; k < count; k++) {
      int64_t to = ((first + k) * rows + at) * array.size + j;
      uint32_t value = from[array.place[j] * W + k];
      if (array.kind == FLAG)
        static_cast<uint8_t *>(data)[to] = value;
      else
        static_cast<uint32_t *>(data)[to] = value;
    }
}

static XLA_FFI_Buffer *buffer(void *told) { return static_cast<XLA_FFI_Buffer *>(told); }

static int64_t elements(const XLA_FFI_Buffer *told) {
  int64_t count = 1;
  for (int64_t axis = 0; axis < told->rank; axis++) count *= told->dims[axis];
  return count;
}

static int64_t attribute(const XLA_FFI_CallFrame *frame, const char *name) {
  for (int64_t k = 0; k < frame->attrs.size; k++) {
    const XLA_FFI_ByteSpan *told = frame->attrs.names[k];
    if (told->len == strlen(name) && memcmp(told->ptr, name, told->len) == 0)
      return *static_cast<int64_t *>(static_cast<XLA_FFI_Scalar *>(frame->attrs.attrs[k])->value);
  }
  return 0;
}

// True if XLA only asks what the function was compiled for, which is told.
static bool asked(XLA_FFI_CallFrame *frame) {
  XLA_FFI_Extension_Base *base = frame->extension_start;
  if (base == nullptr || base->type != XLA_FFI_Extension_Metadata) return false;
  XLA_FFI_Metadata *told = reinterpret_cast<XLA_FFI_Metadata_Extension *>(base)->metadata;
  told->api_version.struct_size = XLA_FFI_Api_Version_STRUCT_SIZE;
  told->api_version.major_version = XLA_FFI_API_MAJOR;
  told->api_version.minor_version = XLA_FFI_API_MINOR;
  told->traits = 0;
  return true;
}

typedef void (*Tick)(F *block, int turn, F *row);

// `ticks` ticks of all walkers. The block's vectors are `fixed` that stay, then twice `moving` that are
// written in turns, so that a tick reads its own start until it has ended.
template <int FIXED, int MOVING, int ROW>
static XLA_FFI_Error *run(XLA_FFI_CallFrame *frame, Tick tick, const Array *given, int givens,
                          const Array *kept, const Array *moved, int moves, const Array *told, int tells) {
  if (asked(frame)) return nullptr;
  const int64_t ticks = attribute(frame, "ticks");
  const int64_t walkers = elements(buffer(frame->args.args[0])) / given[0].size;
  alignas(64) F block[FIXED + 2 * MOVING + 1], row[ROW + 1];
  for (int64_t first = 0; first < walkers; first += W) {
    const int count = walkers - first < W ? walkers - first : W;
    for (int a = 0; a < givens; a++) take(block, given[a], buffer(frame->args.args[a])->data, first, count);
    for (int64_t t = 0; t < ticks; t++) {
      tick(block, t & 1, row);
      for (int a = 0; a < tells; a++)
        give(row, told[a], buffer(frame->rets.rets[moves + a])->data, first, count, ticks, t);
    }
    for (int a = 0; a < moves; a++)
      give(block, ticks & 1 ? moved[a] : kept[a], buffer(frame->rets.rets[a])->data, first, count, 1, 0);
  }
  return nullptr;
}
