/* davar tests - reads counts of three axes on standard input, one sample per line, and prints "axis
 * value low high" for every result. */
#include "accelerometer.h"

#include <stdio.h>

int main(void)
{
    int x = 0;
    int y = 0;
    int z = 0;
    if (accelerometer_start() != DAVAR_OK) {
        return 1;
    }
    while (scanf("%d %d %d", &x, &y, &z) == 3) {
        davar_coefficient_t noise;
        accelerometer_sample((int16_t)x, (int16_t)y, (int16_t)z);
        for (int axis = accelerometer_noise(&noise); axis >= 0;
             axis = accelerometer_noise(&noise)) {
            printf("%d %.9g %.9g %.9g\n", axis, noise.value, noise.low, noise.high);
        }
    }
    return 0;
}
