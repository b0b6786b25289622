// Batches of poses for the benchmarks, one thread.  Rows: (N, 4, 4) poses and (N, 6) lengths, as NumPy holds them.
// Columns: one array a coordinate (structure of arrays), the least a processor can be asked to move.
#include <algorithm>
#include <cmath>

#include "formulas.hpp"

template <class V> INLINE void pose_in(const double* T, Pose<V>& pose) {
    V c[12];
    gather<12>(T, 16, c);
#pragma GCC unroll 3
    for (int r = 0; r < 3; r++) {
        pose.R[3 * r] = c[4 * r], pose.R[3 * r + 1] = c[4 * r + 1], pose.R[3 * r + 2] = c[4 * r + 2];
        pose.t[r] = c[4 * r + 3];
    }
}
template <class V> INLINE void pose_out(const Motion<V>& at, double* T) {
    V R[9], c[16];
    rotation(at.q, R);
#pragma GCC unroll 3
    for (int r = 0; r < 3; r++) {
        c[4 * r] = R[3 * r], c[4 * r + 1] = R[3 * r + 1], c[4 * r + 2] = R[3 * r + 2], c[4 * r + 3] = at.t[r];
    }
    c[12] = c[13] = c[14] = V{}, c[15] = V{} + 1.0;
    scatter<16>(c, T, 16);
}

template <class V> INLINE void ik(const Machine& m, const double* poses, double* out, long k) {
    Pose<V> pose;
    V L[6];
    pose_in(poses + 16 * k, pose);
    lengths(m, pose, L);
    scatter<6>(L, out + 6 * k, 6);
}
template <class V> INLINE void fk(const Machine& m, const double* given, double* out, long k) {
    V L[6];
    Motion<V> at;
    gather<6>(given + 6 * k, 6, L);
    forward(m, L, at);
    pose_out(at, out + 16 * k);
}
template <class V> INLINE void warm(const Machine& m, const double* poses, const double* temps, double* out, long k) {
    Pose<V> pose;
    V T[6], L[6];
    pose_in(poses + 16 * k, pose);
    gather<6>(temps + 6 * k, 6, T);
    corrected(m, pose, T, L);
    scatter<6>(L, out + 6 * k, 6);
}
template <class V> INLINE void rates(const Machine& m, const double* poses, double* out, long k) {
    Pose<V> pose;
    V J[36];
    pose_in(poses + 16 * k, pose);
    jacobian(m, pose, J);
    scatter<36>(J, out + 36 * k, 36);
}

// Whole vectors first, the rest one by one.
template <class Wide, class Narrow> INLINE void each(long n, Wide wide, Narrow narrow) {
    long k = 0;
    for (; k + WIDTH <= n; k += WIDTH) wide(k);
    for (; k < n; k++) narrow(k);
}

typedef Lanes<WIDTH> V;

static void newton_matrix(const double p[6][3], const double b[6][3], const double t[3], const double R[9], double A[6][6]) {
    for (int i = 0; i < 6; i++) {
        double s[3];
        leg(R, t, p[i], b[i], s, A[i]);
        cross(s, A[i], A[i] + 3);
    }
}
static double smallest_pivot(const double given[6][6], const int order[6]) {
    double A[6][6], smallest = INFINITY;
    for (int i = 0; i < 6; i++) std::copy(given[order[i]], given[order[i]] + 6, A[i]);
    for (int k = 0; k < 6; k++) {
        smallest = std::min(smallest, std::fabs(A[k][k]));
        if (!(smallest > 0.0)) return 0.0;
        for (int i = k + 1; i < 6; i++)
            for (int j = 5; j >= k; j--) A[i][j] -= A[i][k] / A[k][k] * A[k][j];
    }
    return smallest;
}

extern "C" {

int lanes() { return WIDTH; }

// law: rows A, B, q0, reference temperature, six legs each.  Returns null where home is singular.
Machine* machine_made(const double* platform, const double* base, const double* home, const double* law) {
    Machine* m = new Machine;
    memcpy(m->platform, platform, sizeof m->platform);
    memcpy(m->base, base, sizeof m->base);
    memcpy(m->A, law, sizeof m->A);
    memcpy(m->B, law + 6, sizeof m->B);
    memcpy(m->q0, law + 12, sizeof m->q0);
    memcpy(m->reference, law + 18, sizeof m->reference);
    double R[9], A[6][6];
    for (int r = 0; r < 3; r++) {
        for (int k = 0; k < 3; k++) R[3 * r + k] = home[4 * r + k];
        m->home_t[r] = home[4 * r + 3];
    }
    // the largest of the four numbers first: a home turned by half a turn has w = 0
    const double four[4] = {1 + R[0] - R[4] - R[8], 1 - R[0] + R[4] - R[8], 1 - R[0] - R[4] + R[8], 1 + R[0] + R[4] + R[8]};
    const double columns[4][4] = {{four[0], R[1] + R[3], R[2] + R[6], R[7] - R[5]},
                                  {R[1] + R[3], four[1], R[5] + R[7], R[2] - R[6]},
                                  {R[2] + R[6], R[5] + R[7], four[2], R[3] - R[1]},
                                  {R[7] - R[5], R[2] - R[6], R[3] - R[1], four[3]}};
    const double* best = columns[std::max_element(four, four + 4) - four];
    const double norm = std::sqrt(best[0] * best[0] + best[1] * best[1] + best[2] * best[2] + best[3] * best[3]);
    for (int k = 0; k < 4; k++) m->home_q[k] = best[k] / norm;

    newton_matrix(m->platform, m->base, m->home_t, R, A);
    int order[6] = {0, 1, 2, 3, 4, 5};
    double largest = 0.0;
    do {
        const double pivot = smallest_pivot(A, order);
        if (pivot > largest) largest = pivot, std::copy(order, order + 6, m->order);
    } while (std::next_permutation(order, order + 6));
    if (!(largest > 0.0)) return delete m, nullptr;
    for (int i = 0; i < 6; i++) {
        memcpy(m->pivot_platform[i], m->platform[m->order[i]], sizeof m->platform[i]);
        memcpy(m->pivot_base[i], m->base[m->order[i]], sizeof m->base[i]);
    }
    newton_matrix(m->pivot_platform, m->pivot_base, m->home_t, R, A);
    for (int column = 0; column < 6; column++) {
        double rows[6][7], x[6];
        for (int i = 0; i < 6; i++) std::copy(A[i], A[i] + 6, rows[i]), rows[i][6] = i == column;
        eliminate(rows, x);
        for (int i = 0; i < 6; i++) m->inverse[i][column] = x[i];
    }
    return m;
}
void machine_freed(Machine* m) { delete m; }

void lengths_rows(const Machine* m, long n, const double* poses, double* out) {
    each(n, [=](long k) { ik<V>(*m, poses, out, k); }, [=](long k) { ik<double>(*m, poses, out, k); });
}
void forward_rows(const Machine* m, long n, const double* given, double* out) {
    each(n, [=](long k) { fk<V>(*m, given, out, k); }, [=](long k) { fk<double>(*m, given, out, k); });
}
void corrected_rows(const Machine* m, long n, const double* poses, const double* temps, double* out) {
    each(n, [=](long k) { warm<V>(*m, poses, temps, out, k); }, [=](long k) { warm<double>(*m, poses, temps, out, k); });
}
void jacobian_rows(const Machine* m, long n, const double* poses, double* out) {
    each(n, [=](long k) { rates<V>(*m, poses, out, k); }, [=](long k) { rates<double>(*m, poses, out, k); });
}

// One pose after the other, plain doubles.
void lengths_single(const Machine* m, long n, const double* poses, double* out) {
    for (long k = 0; k < n; k++) ik<double>(*m, poses, out, k);
}
void forward_single(const Machine* m, long n, const double* given, double* out) {
    for (long k = 0; k < n; k++) fk<double>(*m, given, out, k);
}
void corrected_single(const Machine* m, long n, const double* poses, const double* temps, double* out) {
    for (long k = 0; k < n; k++) warm<double>(*m, poses, temps, out, k);
}
void jacobian_single(const Machine* m, long n, const double* poses, double* out) {
    for (long k = 0; k < n; k++) rates<double>(*m, poses, out, k);
}

// Columns: seven arrays x, y, z, qx, qy, qz, qw of n poses; six of lengths.  n is a multiple of 8.
void lengths_columns(const Machine* m, long n, const double* motions, double* out) {
    for (long k = 0; k < n; k += WIDTH) {
        V q[4], L[6];
        Pose<V> pose;
        for (int i = 0; i < 3; i++) pose.t[i] = load_part<WIDTH, V>(motions + i * n + k);
        for (int i = 0; i < 4; i++) q[i] = load_part<WIDTH, V>(motions + (3 + i) * n + k);
        rotation(q, pose.R);
        lengths(*m, pose, L);
        for (int i = 0; i < 6; i++) store_part<WIDTH>(out + i * n + k, L[i]);
    }
}
void forward_columns(const Machine* m, long n, const double* given, double* out) {
    for (long k = 0; k < n; k += WIDTH) {
        V L[6];
        Motion<V> at;
        for (int i = 0; i < 6; i++) L[i] = load_part<WIDTH, V>(given + i * n + k);
        forward(*m, L, at);
        for (int i = 0; i < 3; i++) store_part<WIDTH>(out + i * n + k, at.t[i]);
        for (int i = 0; i < 4; i++) store_part<WIDTH>(out + (3 + i) * n + k, at.q[i]);
    }
}

// Draws around home: three chord steps with the inverse of home's matrix, nothing checked.  Columns as above; n is a
// multiple of 8.
void draws_columns(const Machine* m, long n, const double* given, double* out) {
    for (long k = 0; k < n; k += WIDTH) {
        V half_square[6];
        Motion<V> at;
        for (int i = 0; i < 6; i++) {
            const V L = load_part<WIDTH, V>(given + m->order[i] * n + k);
            half_square[i] = 0.5 * L * L;
        }
        for (int i = 0; i < 3; i++) at.t[i] = V{} + m->home_t[i];
        for (int i = 0; i < 4; i++) at.q[i] = V{} + m->home_q[i];
        for (int step = 0; step < 3; step++) chord(*m, half_square, at);
        for (int i = 0; i < 3; i++) store_part<WIDTH>(out + i * n + k, at.t[i]);
        for (int i = 0; i < 4; i++) store_part<WIDTH>(out + (3 + i) * n + k, at.q[i]);
    }
}
}
