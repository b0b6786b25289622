// The equations of a hexapod, each once, on a lane type V: a double, or a vector of W poses.
// Leg i runs from base joint b to platform joint p: s = R p, d = t + s - b, L = |d|.
#pragma once
#include "lanes.hpp"

struct Machine {
    double platform[6][3], base[6][3];                              // legs in the machine's order
    double pivot_platform[6][3], pivot_base[6][3];                  // legs in the order of elimination
    int order[6];
    double home_t[3], home_q[4], home_half_square[6], inverse[6][6];  // inverse of Newton's matrix at home
    double A[6], B[6], q0[6], reference[6];                         // one thermometer a leg, plates not compensated
};

template <class V> struct Pose { V R[9], t[3]; };
template <class V> struct Motion { V t[3], q[4]; };                 // q = (x, y, z, w), a unit quaternion

template <class V> INLINE void rotation(const V q[4], V R[9]) {
    const V x2 = q[0] + q[0], y2 = q[1] + q[1], z2 = q[2] + q[2];
    const V xx = q[0] * x2, yy = q[1] * y2, zz = q[2] * z2, xy = q[0] * y2, xz = q[0] * z2, yz = q[1] * z2;
    const V wx = q[3] * x2, wy = q[3] * y2, wz = q[3] * z2;
    R[0] = 1.0 - (yy + zz), R[1] = xy - wz, R[2] = xz + wy;
    R[3] = xy + wz, R[4] = 1.0 - (xx + zz), R[5] = yz - wx;
    R[6] = xz - wy, R[7] = yz + wx, R[8] = 1.0 - (xx + yy);
}

template <class V> INLINE void leg(const V R[9], const V t[3], const double p[3], const double b[3], V s[3], V d[3]) {
#pragma GCC unroll 3
    for (int k = 0; k < 3; k++) {
        s[k] = R[3 * k] * p[0] + R[3 * k + 1] * p[1] + R[3 * k + 2] * p[2];
        d[k] = (t[k] - b[k]) + s[k];
    }
}
template <class V> INLINE V dot(const V a[3], const V b[3]) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
template <class V> INLINE void cross(const V a[3], const V b[3], V c[3]) {
    c[0] = a[1] * b[2] - a[2] * b[1], c[1] = a[2] * b[0] - a[0] * b[2], c[2] = a[0] * b[1] - a[1] * b[0];
}

template <class V> INLINE void lengths(const Machine& m, const Pose<V>& pose, V L[6]) {
#pragma GCC unroll 6
    for (int i = 0; i < 6; i++) {
        V s[3], d[3];
        leg(pose.R, pose.t, m.platform[i], m.base[i], s, d);
        L[i] = root(dot(d, d));
    }
}

// corrected = q0 + (L - q0 - a q0) / (1 + b), a = A dT, b = B dT
template <class V> INLINE void corrected(const Machine& m, const Pose<V>& pose, const V temps[6], V L[6]) {
    lengths(m, pose, L);
#pragma GCC unroll 6
    for (int i = 0; i < 6; i++) {
        const V dT = temps[i] - m.reference[i];
        L[i] = m.q0[i] + (L[i] - m.q0[i] - m.A[i] * dT * m.q0[i]) / (1.0 + m.B[i] * dT);
    }
}

// rows [u, s x u]
template <class V> INLINE void jacobian(const Machine& m, const Pose<V>& pose, V J[36]) {
#pragma GCC unroll 6
    for (int i = 0; i < 6; i++) {
        V s[3], d[3];
        leg(pose.R, pose.t, m.platform[i], m.base[i], s, d);
        const V n = 1.0 / root(dot(d, d));
        V* row = J + 6 * i;
        row[0] = d[0] * n, row[1] = d[1] * n, row[2] = d[2] * n;
        cross(s, row, row + 3);
    }
}

// Cayley's map of the step x = (translation, rotation vector): second order, no trigonometry
template <class V> INLINE void move(Motion<V>& at, const V x[6]) {
    const V a = 0.5 * x[3], b = 0.5 * x[4], c = 0.5 * x[5];
    V* q = at.q;
    const V i = q[0] + a * q[3] + b * q[2] - c * q[1], j = q[1] + b * q[3] + c * q[0] - a * q[2];
    const V k = q[2] + c * q[3] + a * q[1] - b * q[0], w = q[3] - a * q[0] - b * q[1] - c * q[2];
    const V n = 1.0 / root(i * i + j * j + k * k + w * w);
    q[0] = i * n, q[1] = j * n, q[2] = k * n, q[3] = w * n;
    at.t[0] += x[0], at.t[1] += x[1], at.t[2] += x[2];
}

// Newton's system for squared lengths, rows [d, s x d | (L^2 - d.d)/2]: no root, no division
template <class V> INLINE void newton_rows(const Machine& m, const Motion<V>& at, const V half_square[6], V A[6][7]) {
    V R[9];
    rotation(at.q, R);
#pragma GCC unroll 6
    for (int i = 0; i < 6; i++) {
        V s[3];
        leg(R, at.t, m.pivot_platform[i], m.pivot_base[i], s, A[i]);
        cross(s, A[i], A[i] + 3);
        A[i][6] = half_square[i] - 0.5 * dot(A[i], A[i]);
    }
}

// Gauss, no pivoting: the order of the rows was chosen at home
template <class V> INLINE void eliminate(V A[6][7], V x[6]) {
    V inverse[6];
#pragma GCC unroll 6
    for (int k = 0; k < 6; k++) {
        inverse[k] = reciprocal(A[k][k]);
#pragma GCC unroll 6
        for (int i = k + 1; i < 6; i++) {
            const V f = A[i][k] * inverse[k];
#pragma GCC unroll 7
            for (int j = k + 1; j < 7; j++) A[i][j] -= f * A[k][j];
        }
    }
#pragma GCC unroll 6
    for (int k = 5; k >= 0; k--) {
        V value = A[k][6];
#pragma GCC unroll 6
        for (int j = k + 1; j < 6; j++) value -= A[k][j] * x[j];
        x[k] = value * inverse[k];
    }
}

// One chord step: Newton's step with the inverse of home's matrix
template <class V> INLINE void chord(const Machine& m, const V half_square[6], Motion<V>& at) {
    V R[9], r[6], x[6];
    rotation(at.q, R);
#pragma GCC unroll 6
    for (int i = 0; i < 6; i++) {
        V s[3], d[3];
        leg(R, at.t, m.pivot_platform[i], m.pivot_base[i], s, d);
        r[i] = half_square[i] - 0.5 * dot(d, d);
    }
#pragma GCC unroll 6
    for (int k = 0; k < 6; k++) {
        x[k] = m.inverse[k][0] * r[0];
#pragma GCC unroll 6
        for (int i = 1; i < 6; i++) x[k] += m.inverse[k][i] * r[i];
    }
    move(at, x);
}

constexpr double STEP = 1e-7;   // m and rad: the error left is its square
constexpr int MOST_STEPS = 20;
constexpr int CHORDS = 1;

// Pose of six lengths (the machine's order) from home; NaN where it did not converge.
template <class V> INLINE void forward(const Machine& m, const V L[6], Motion<V>& at) {
    V half_square[6];
#pragma GCC unroll 6
    for (int i = 0; i < 6; i++) half_square[i] = 0.5 * L[m.order[i]] * L[m.order[i]];
    for (int k = 0; k < 3; k++) at.t[k] = V{} + m.home_t[k];
    for (int k = 0; k < 4; k++) at.q[k] = V{} + m.home_q[k];
    for (int k = 0; k < CHORDS; k++) chord(m, half_square, at);
    for (int step = 0; step < MOST_STEPS; step++) {
        V A[6][7], x[6];
        newton_rows(m, at, half_square, A);
        eliminate(A, x);
        move(at, x);
        V size = magnitude(x[0]);
#pragma GCC unroll 6
        for (int k = 1; k < 6; k++) size = larger(size, magnitude(x[k]));
        if (!any_above(size, STEP)) return;
    }
    at.t[0] = V{} + __builtin_nan("");
}
