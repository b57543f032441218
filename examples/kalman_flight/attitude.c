/* An attitude filter. */
#include "attitude.h"

#include <math.h>
#include <string.h>

typedef double matrix_t[3][3];

/* out = a b, or a b' */
static void product(const matrix_t a, const matrix_t b, int transposed, matrix_t out)
{
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++) {
            out[i][j] = 0.0;
            for (int k = 0; k < 3; k++) {
                out[i][j] += a[i][k] * (transposed ? b[j][k] : b[k][j]);
            }
        }
    }
}

static void inverse(const matrix_t a, matrix_t out)
{
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++) {
            const int r = (j + 1) % 3;
            const int s = (j + 2) % 3;
            const int u = (i + 1) % 3;
            const int v = (i + 2) % 3;
            out[i][j] = (a[r][u] * a[s][v]) -
                        (a[r][v] * a[s][u]); /* the cofactor; the cyclic indices give its sign */
        }
    }
    const double determinant =
        (a[0][0] * out[0][0]) + (a[0][1] * out[1][0]) + (a[0][2] * out[2][0]);
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++) {
            out[i][j] /= determinant;
        }
    }
}

void quaternion_product(const double a[4], const double b[4], double out[4])
{
    out[0] = (a[3] * b[0]) + (a[0] * b[3]) + (a[1] * b[2]) - (a[2] * b[1]);
    out[1] = (a[3] * b[1]) - (a[0] * b[2]) + (a[1] * b[3]) + (a[2] * b[0]);
    out[2] = (a[3] * b[2]) + (a[0] * b[1]) - (a[1] * b[0]) + (a[2] * b[3]);
    out[3] = (a[3] * b[3]) - (a[0] * b[0]) - (a[1] * b[1]) - (a[2] * b[2]);
}

void quaternion_of(const double rotation[3], double out[4])
{
    const double angle = sqrt((rotation[0] * rotation[0]) + (rotation[1] * rotation[1]) +
                              (rotation[2] * rotation[2]));
    const double scale = (angle > 1e-12) ? (sin(angle / 2.0) / angle) : 0.5;
    for (int i = 0; i < 3; i++) {
        out[i] = scale * rotation[i];
    }
    out[3] = cos(angle / 2.0);
}

void quaternion_between(const double a[4], const double b[4], double rotation[3])
{
    const double back[4] = {-a[0], -a[1], -a[2], a[3]};
    double turn[4];
    quaternion_product(back, b, turn);
    for (int i = 0; i < 3; i++) {
        rotation[i] = ((turn[3] < 0.0) ? -2.0 : 2.0) * turn[i];
    }
}

static void turn_by(attitude_t *attitude, const double rotation[3])
{
    double turn[4];
    double next[4];
    quaternion_of(rotation, turn);
    quaternion_product(attitude->q, turn, next);
    const double norm =
        sqrt((next[0] * next[0]) + (next[1] * next[1]) + (next[2] * next[2]) + (next[3] * next[3]));
    for (int i = 0; i < 4; i++) {
        attitude->q[i] = next[i] / norm;
    }
}

void attitude_start(attitude_t *attitude, const double q[4], double attitude_sigma,
                    double bias_sigma)
{
    memset(attitude, 0, sizeof *attitude);
    memcpy(attitude->q, q, sizeof attitude->q);
    for (int i = 0; i < 3; i++) {
        attitude->aa[i][i] = attitude_sigma * attitude_sigma;
        attitude->bb[i][i] = bias_sigma * bias_sigma;
    }
}

void attitude_propagate(attitude_t *attitude, const double rate[3], double step_s,
                        const double noise[3], double walk)
{
    double turn[3];
    for (int i = 0; i < 3; i++) {
        turn[i] = (rate[i] - attitude->bias[i]) * step_s;
    }
    turn_by(attitude, turn);
    const matrix_t m = {
        {1.0, turn[2], -turn[1]}, {-turn[2], 1.0, turn[0]}, {turn[1], -turn[0], 1.0}};
    matrix_t moved;
    matrix_t aa;
    matrix_t ab;
    product(m, attitude->aa, 0, moved);
    product(moved, m, 1, aa);
    product(m, attitude->ab, 0, ab);
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++) {
            attitude->aa[i][j] = aa[i][j] - (step_s * (ab[i][j] + ab[j][i])) +
                                 (step_s * step_s * attitude->bb[i][j]);
            attitude->ab[i][j] = ab[i][j] - (step_s * attitude->bb[i][j]);
        }
        attitude->aa[i][i] +=
            noise[i] * noise[i] * step_s; /* the process noise that davar measures */
        attitude->bb[i][i] += walk * walk * step_s;
    }
}

void attitude_update(attitude_t *attitude, const double measured[4], double sigma)
{
    matrix_t sum;
    memcpy(sum, attitude->aa, sizeof sum);
    for (int i = 0; i < 3; i++) {
        sum[i][i] += sigma * sigma;
    }
    matrix_t weight;
    matrix_t of_attitude;
    matrix_t of_bias;
    matrix_t ba;
    inverse(sum, weight);
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++) {
            ba[i][j] = attitude->ab[j][i];
        }
    }
    product(attitude->aa, weight, 0, of_attitude);
    product(ba, weight, 0, of_bias);
    matrix_t aa;
    matrix_t ab;
    matrix_t bb;
    product(of_attitude, attitude->aa, 0, aa);
    product(of_attitude, attitude->ab, 0, ab);
    product(of_bias, attitude->ab, 0, bb);
    double off[3];
    double turn[3] = {0.0, 0.0, 0.0};
    quaternion_between(attitude->q, measured, off);
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++) {
            turn[i] += of_attitude[i][j] * off[j];
            attitude->bias[i] += of_bias[i][j] * off[j];
            attitude->aa[i][j] -= aa[i][j];
            attitude->ab[i][j] -= ab[i][j];
            attitude->bb[i][j] -= bb[i][j];
        }
    }
    turn_by(attitude, turn);
}

double attitude_nees(const attitude_t *attitude, const double truth[4], double error[3])
{
    matrix_t weight;
    double sum = 0.0;
    quaternion_between(attitude->q, truth, error);
    inverse(attitude->aa, weight);
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++) {
            sum += error[i] * weight[i][j] * error[j];
        }
    }
    return sum;
}
