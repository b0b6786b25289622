// Lanes: W poses side by side in one vector of W doubles (a GCC vector type), W = 8, 4 or 2 as the processor has it.
// W = 1 is a plain double.  A batch of rows is turned into lanes and back by transposing blocks of W x W in registers.
#pragma once
#include <cstring>
#include <type_traits>
#include <utility>
#if defined(__AVX__)
#include <immintrin.h>
#endif

#define INLINE inline __attribute__((always_inline))

#if defined(__AVX512F__)
constexpr int WIDTH = 8;
#elif defined(__AVX__)
constexpr int WIDTH = 4;
#else
constexpr int WIDTH = 2;
#endif

template <int W> struct LanesOf { typedef double type __attribute__((vector_size(W * sizeof(double)))); };
template <> struct LanesOf<1> { typedef double type; };
template <int W> using Lanes = typename LanesOf<W>::type;
template <class V> constexpr int width_of = sizeof(V) / sizeof(double);

INLINE double root(double x) { return __builtin_sqrt(x); }
INLINE double reciprocal(double x) { return 1.0 / x; }
INLINE double larger(double a, double b) { return a > b ? a : b; }
INLINE double magnitude(double a) { return __builtin_fabs(a); }
INLINE bool any_above(double a, double limit) { return a > limit; }

template <class V, class = std::enable_if_t<(width_of<V> > 1)>> INLINE V root(V x) {
#if defined(__AVX512F__)
    if constexpr (width_of<V> == 8) return (V)_mm512_sqrt_pd((__m512d)x);
#endif
#if defined(__AVX__)
    if constexpr (width_of<V> == 4) return (V)_mm256_sqrt_pd((__m256d)x);
#endif
    V y;
    for (int j = 0; j < width_of<V>; j++) y[j] = __builtin_sqrt(x[j]);
    return y;
}
// A pivot's reciprocal may be good to 28 bits only: Newton's next step mends what it leaves.
template <class V, class = std::enable_if_t<(width_of<V> > 1)>> INLINE V reciprocal(V x) {
#if defined(__AVX512F__)
    if constexpr (width_of<V> == 8) {
        V r = (V)_mm512_rcp14_pd((__m512d)x);
        return r * (2.0 - x * r);
    }
#endif
    return 1.0 / x;
}
template <class V, class = std::enable_if_t<(width_of<V> > 1)>> INLINE V larger(V a, V b) { return a > b ? a : b; }
template <class V, class = std::enable_if_t<(width_of<V> > 1)>> INLINE V magnitude(V a) { return a < 0.0 ? -a : a; }
template <class V, class = std::enable_if_t<(width_of<V> > 1)>> INLINE bool any_above(V a, double limit) {
    bool any = false;
    for (int j = 0; j < width_of<V>; j++) any |= a[j] > limit;
    return any;
}

// The first K doubles at p, the other lanes 0; and the way back.
template <int K, class V> INLINE V load_part(const double* p) {
    V v = V{};
#if defined(__AVX512F__)
    if constexpr (width_of<V> == 8 && K < 8) return (V)_mm512_maskz_loadu_pd((1 << K) - 1, p);
#endif
    memcpy(&v, p, K * sizeof(double));
    return v;
}
template <int K, class V> INLINE void store_part(double* p, V v) {
#if defined(__AVX512F__)
    if constexpr (width_of<V> == 8 && K < 8) {
        _mm512_mask_storeu_pd(p, (1 << K) - 1, (__m512d)v);
        return;
    }
#endif
    memcpy(p, &v, K * sizeof(double));
}

// One stage of a transposition: exchange the blocks of B lanes off the diagonal of each pair of vectors.
template <int B, class V, int... k> INLINE void exchange(V& a, V& b, std::integer_sequence<int, k...>) {
    constexpr int W = width_of<V>;
    typedef long long Mask __attribute__((vector_size(W * sizeof(double))));
    const Mask low = {((k & B) ? W + k - B : k)...}, high = {((k & B) ? W + k : k + B)...};
    const V first = __builtin_shuffle(a, b, low), second = __builtin_shuffle(a, b, high);
    a = first;
    b = second;
}
template <int B, class V> INLINE void transposed(V v[]) {
    constexpr int W = width_of<V>;
    if constexpr (B < W) {
#pragma GCC unroll 8
        for (int i = 0; i < W; i++)
            if (!(i & B)) exchange<B>(v[i], v[i + B], std::make_integer_sequence<int, W>{});
        transposed<2 * B>(v);
    }
}

// K numbers of each of W poses, `stride` doubles from pose to pose -> K lanes, and the way back.
template <int K, class V> INLINE void gather(const double* p, long stride, V out[K]) {
    constexpr int W = width_of<V>;
    if constexpr (W == 1) {
        for (int k = 0; k < K; k++) out[k] = p[k];
    } else if constexpr (K > 0) {
        constexpr int part = K < W ? K : W;
        V block[W];
#pragma GCC unroll 8
        for (int j = 0; j < W; j++) block[j] = load_part<part, V>(p + j * stride);
        transposed<1>(block);
#pragma GCC unroll 8
        for (int k = 0; k < part; k++) out[k] = block[k];
        gather<K - part>(p + part, stride, out + part);
    }
}
template <int K, class V> INLINE void scatter(const V in[K], double* p, long stride) {
    constexpr int W = width_of<V>;
    if constexpr (W == 1) {
        for (int k = 0; k < K; k++) p[k] = in[k];
    } else if constexpr (K > 0) {
        constexpr int part = K < W ? K : W;
        V block[W];
#pragma GCC unroll 8
        for (int k = 0; k < W; k++) block[k] = k < part ? in[k] : V{};
        transposed<1>(block);
#pragma GCC unroll 8
        for (int j = 0; j < W; j++) store_part<part, V>(p + j * stride, block[j]);
        scatter<K - part>(in + part, p + part, stride);
    }
}
