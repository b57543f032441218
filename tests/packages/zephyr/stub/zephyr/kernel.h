/* Stands in for Zephyr's kernel: samples of the gyro arrive during sleep. */
#ifndef STUB_KERNEL_H
#define STUB_KERNEL_H
typedef struct {
    int seconds;
} k_timeout_t;
#define K_SECONDS(s) ((k_timeout_t){s})
int k_sleep(k_timeout_t timeout);
#endif
