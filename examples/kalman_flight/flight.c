/* davar example - the use of the results: the measured angle random walk sets the gyro noise of an
 * attitude filter in flight. In the simulated flight the gyro noise triples for three minutes. The
 * same filter runs with four assumptions about that noise.
 *
 *   flight [--law glr|or|fixed] [--flights N] [--seed S] [--steady] [--csv FILE]
 *
 * Prints the rms attitude error and the consistency, one line for each phase and assumption. */
#include "attitude.h"
#include "davar/fit.h"

#include <davar/davar.h>
#include <davar/fit.h>
#include <davar/glr.h>

#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define RATE_HZ 100
#define SECONDS 660
#define LSB_DPS 0.005
#define BENCH 0.3        /* angle random walk at rest, deg/sqrt(h) */
#define LOUD 3.0         /* ratio of the noise while it vibrates */
#define TRACKER_DEG 0.05 /* of an attitude measurement, once per second */
#define BIAS_DPS 0.01    /* at the start, unknown */
#define BIAS_WALK 1e-5   /* deg/s/sqrt(s) */
/* slow compared with the cluster times; otherwise the motion counts as noise */
#define MOTION_DPS 0.5
#define RADIAN 0.017453292519943 /* one degree in rad */
#define TAUS 4

enum { AS_ON_THE_BENCH, AS_AT_WORST, FED, TRUE, BELIEFS };
static const char *const beliefs[BELIEFS] = {"bench", "worst", "fed", "true"};
static const struct {
    const char *name;
    int from;
    int to;
} phases[] = {{"quiet", 60, 240}, {"loud", 240, 420}, {"after", 420, SECONDS}};
#define PHASES 3

static const uint32_t taus[TAUS] = {1, 2, 4, 8};
static davar_config_t config;
static davar_plan_t plan;
static davar_t gyro[3]; /* x, y, z */
static uint64_t memory[3][65536 / 8];

static struct {
    double square; /* of the error of attitude, deg^2, sum over flights and axes */
    double nees;   /* sum over flights */
    double fed;    /* results of davar, deg/sqrt(h), sum over flights and axes */
} seen[SECONDS][BELIEFS];

static uint64_t state;

static double uniform(void)
{
    state = (state * 6364136223846793005U) + 1442695040888963407U;
    return ((double)(state >> 11U) + 0.5) / 9007199254740992.0;
}

static double gauss(void)
{
    const double radius = sqrt(-2.0 * log(uniform()));
    return radius * cos(6.283185307179586 * uniform());
}

/* True value in deg/sqrt(h). */
static double arw_at(int second, int steady)
{
    return (!steady && (second >= phases[1].from) && (second < phases[1].to)) ? LOUD * BENCH
                                                                              : BENCH;
}

static int is_law(const char *law)
{
    return strcmp(law, "glr") == 0 || strcmp(law, "or") == 0 || strcmp(law, "fixed") == 0;
}

static void choose_law(const char *law)
{
    config = davar_default_config;
    config.rate_hz = RATE_HZ;
    config.unit_per_count = LSB_DPS;
    config.stride = 10;
    config.taus = taus;
    config.tau_count = TAUS;
    config.window.grow = 1;
    if (strcmp(law, "glr") == 0) {
        config.law = &davar_law_glr_q15;
        config.window.longest = 3000;
        config.window.shortest = 20;
        config.moments.segment = 0;
        config.window.shrink = 64;
    } else {
        config.law = (strcmp(law, "or") == 0) ? &davar_law_or : NULL;
    }
    davar_plan_init_white(&plan, taus, TAUS);
}

/* Reads the results of davar: the ARW of white noise, or the Allan deviation of one sample if the
 * noise has other parts too. */
static void listen(double arw[3])
{
    static davar_result_t result;
    for (int axis = 0; axis < 3; axis++) {
        if (!davar_take(&gyro[axis], &result)) {
            continue;
        }
        const davar_coefficient_t *const white = &result.coefficient[DAVAR_ANGLE_RANDOM_WALK];
        (void)davar_fit_white(&plan, config.rate_hz, &result);
        const double said =
            white->present ? white->value : result.tau[0].adev * 60.0 / sqrt(RATE_HZ);
        arw[axis] = (isfinite(said) && (said > 0.0)) ? said : arw[axis];
    }
}

static void fly(int steady)
{
    double truth[4] = {0.0, 0.0, 0.0, 1.0};
    double bias[3];
    double arw[BELIEFS][3];
    attitude_t filter[BELIEFS];
    double off[3];
    double begin[4];
    for (int i = 0; i < 3; i++) {
        bias[i] = BIAS_DPS * gauss();
        off[i] = TRACKER_DEG * RADIAN * gauss();
        arw[FED][i] = BENCH;
    }
    quaternion_of(off, begin);
    for (int k = 0; k < BELIEFS; k++) {
        attitude_start(&filter[k], begin, TRACKER_DEG * RADIAN, BIAS_DPS * RADIAN);
    }
    for (int i = 0; i < 3; i++) {
        if (davar_init_q15(&gyro[i], &config, memory[i], sizeof memory[i]) != DAVAR_OK) {
            fprintf(stderr, "flight: davar rejected its settings\n");
            exit(2);
        }
    }
    for (int n = 0; n < SECONDS * RATE_HZ; n++) {
        const double now = arw_at(n / RATE_HZ, steady);
        int16_t count[3];
        double rate[3];
        double turn[3];
        for (int i = 0; i < 3; i++) {
            const double motion =
                MOTION_DPS * sin(6.283185307179586 * n / RATE_HZ / (40.0 + (10.0 * i)));
            bias[i] += BIAS_WALK * gauss() / sqrt(RATE_HZ);
            count[i] = (int16_t)lround((motion + bias[i] + (now / 60.0 * sqrt(RATE_HZ) * gauss())) /
                                       LSB_DPS);
            rate[i] = count[i] * LSB_DPS * RADIAN;
            turn[i] = motion * RADIAN / RATE_HZ;
            arw[AS_ON_THE_BENCH][i] = BENCH;
            arw[AS_AT_WORST][i] = LOUD * BENCH;
            arw[TRUE][i] = now;
        }
        double step[4];
        double next[4];
        quaternion_of(turn, step);
        quaternion_product(truth, step, next);
        memcpy(truth, next, sizeof truth);

        for (int i = 0; i < 3; i++) {
            davar_push_q15(&gyro[i], &count[i], 1);
        }
        listen(arw[FED]);
        for (int k = 0; k < BELIEFS; k++) {
            double noise[3];
            for (int i = 0; i < 3; i++) {
                noise[i] = arw[k][i] / 60.0 * RADIAN; /* deg/sqrt(h) -> rad/sqrt(s) */
            }
            attitude_propagate(&filter[k], rate, 1.0 / RATE_HZ, noise, BIAS_WALK * RADIAN);
        }
        if ((n + 1) % RATE_HZ == 0) {
            double measured[4];
            for (int i = 0; i < 3; i++) {
                off[i] = TRACKER_DEG * RADIAN * gauss();
            }
            quaternion_of(off, step);
            quaternion_product(truth, step, measured);
            for (int k = 0; k < BELIEFS; k++) {
                double error[3];
                attitude_update(&filter[k], measured, TRACKER_DEG * RADIAN);
                seen[n / RATE_HZ][k].nees += attitude_nees(&filter[k], truth, error);
                for (int i = 0; i < 3; i++) {
                    seen[n / RATE_HZ][k].square += error[i] * error[i] / (RADIAN * RADIAN);
                    seen[n / RATE_HZ][k].fed += arw[k][i];
                }
            }
        }
    }
}

/* One bound of chi-square over its degrees of freedom; both bounds together cover 95 % (Wilson &
 * Hilferty 1931). */
static double bound(double degrees, double sign)
{
    const double root =
        1.0 - (2.0 / (9.0 * degrees)) + (sign * 1.95996 * sqrt(2.0 / (9.0 * degrees)));
    return root * root * root;
}

static void report(int flights)
{
    const double low = bound(3.0 * flights, -1.0);
    const double high = bound(3.0 * flights, 1.0);
    printf("phase,belief,rms_deg,nees_over_3,share_within_95\n");
    for (int p = 0; p < PHASES; p++) {
        for (int k = 0; k < BELIEFS; k++) {
            double square = 0.0;
            double nees = 0.0;
            int within = 0;
            for (int s = phases[p].from; s < phases[p].to; s++) {
                const double mean = seen[s][k].nees / (3.0 * flights);
                square += seen[s][k].square / (3.0 * flights);
                nees += mean;
                within += ((mean > low) && (mean < high)) ? 1 : 0;
            }
            const double seconds = phases[p].to - phases[p].from;
            printf("%s,%s,%.5f,%.3f,%.3f\n", phases[p].name, beliefs[k], sqrt(square / seconds),
                   nees / seconds, within / seconds);
        }
    }
}

static int write_course(const char *path, int flights)
{
    FILE *const file = fopen(path, "w");
    if (file == NULL) {
        perror(path);
        return 1;
    }
    fprintf(file, "time_s,belief,rms_deg,nees_over_3,arw_deg_per_sqrt_h\n");
    for (int s = 0; s < SECONDS; s++) {
        for (int k = 0; k < BELIEFS; k++) {
            const double all = 3.0 * flights;
            fprintf(file, "%d,%s,%.6f,%.4f,%.4f\n", s + 1, beliefs[k],
                    sqrt(seen[s][k].square / all), seen[s][k].nees / all, seen[s][k].fed / all);
        }
    }
    return (fclose(file) == 0) ? 0 : 1;
}

int main(int argc, char **argv)
{
    const char *law = "glr";
    const char *course = NULL;
    long flights = 50;
    int steady = 0;
    state = 1;
    for (int i = 1; i < argc; i++) {
        const char *const value = (i + 1 < argc) ? argv[i + 1] : "";
        if (strcmp(argv[i], "--steady") == 0) {
            steady = 1;
            continue;
        }
        if (strcmp(argv[i], "--law") == 0 && is_law(value)) {
            law = value;
        } else if (strcmp(argv[i], "--flights") == 0 && (flights = strtol(value, NULL, 10)) > 0 &&
                   flights <= 100000) {
        } else if (strcmp(argv[i], "--seed") == 0 && *value != '\0') {
            state = strtoull(value, NULL, 10);
        } else if (strcmp(argv[i], "--csv") == 0 && *value != '\0') {
            course = value;
        } else {
            fprintf(stderr, "usage: flight [--law glr|or|fixed] [--flights N] [--seed S] "
                            "[--steady] [--csv FILE]\n");
            return 2;
        }
        i++;
    }
    choose_law(law);
    for (long f = 0; f < flights; f++) {
        fly(steady);
    }
    report((int)flights);
    return (course != NULL) ? write_course(course, (int)flights) : 0;
}
