/* davar-sim - the monotonic clock. */
#ifndef SIM_CLOCK_H
#define SIM_CLOCK_H

/* Seconds since an arbitrary moment in the past; never runs backwards. */
double sim_clock_s(void);

#endif
