/* An attitude filter: multiplicative extended Kalman filter of attitude error and gyro bias, in body
 * axes, rad and s. Markley & Crassidis, Fundamentals of Spacecraft Attitude Determination and
 * Control (2014), section 6.2. */
#ifndef ATTITUDE_H
#define ATTITUDE_H

typedef struct {
    double q[4];     /* scalar last; truth = q * small rotation */
    double bias[3];  /* rad/s */
    double aa[3][3]; /* covariance of attitude, */
    double ab[3][3]; /* of attitude with bias, */
    double bb[3][3]; /* of bias */
} attitude_t;

void quaternion_product(const double a[4], const double b[4], double out[4]);
/* The rotation by a vector: axis times angle. */
void quaternion_of(const double rotation[3], double out[4]);
/* The small rotation from a to b. */
void quaternion_between(const double a[4], const double b[4], double rotation[3]);

void attitude_start(attitude_t *attitude, const double q[4], double attitude_sigma,
                    double bias_sigma);

/* Propagates by one gyro sample. noise: angle random walk of each axis, rad/sqrt(s); this example
 * sets it. walk: of the bias, rad/s/sqrt(s). */
void attitude_propagate(attitude_t *attitude, const double rate[3], double step_s,
                        const double noise[3], double walk);

/* Updates with a measured attitude; sigma of each axis in rad. */
void attitude_update(attitude_t *attitude, const double measured[4], double sigma);

/* The squared attitude error in units of the filter's own covariance (NEES). Its mean is 3 if the
 * filter is consistent. */
double attitude_nees(const attitude_t *attitude, const double truth[4], double error[3]);

#endif
