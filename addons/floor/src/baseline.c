/* davar - floor: a flight against earlier flights of the same craft (14.7). */
#include "davar/floor.h"

#include "number/scaled.h"

#define FLOOR_BANDS DAVAR_FLOOR_BANDS
#define FLOOR_FLIGHTS_LEAST 3U
#define FLOOR_WINDOWS_LEAST 8U
#define FLOOR_FLIGHTS_MOST 100U  /* then the mean follows slowly */
#define FLOOR_SCATTER_LEAST 0.2F /* of flights, relative: what one craft has */

/* 97.5 % of Student's t, by degrees of freedom from 2 on. */
static const float student[] = {4.303F, 3.182F, 2.776F, 2.571F, 2.447F, 2.365F, 2.306F, 2.262F};

static float student_of(uint32_t freedom)
{
    const uint32_t count = (uint32_t)(sizeof student / sizeof student[0]);
    const float beyond = 1.96F + 2.5F / (float)freedom;
    return (freedom - 2U < count) ? student[freedom - 2U] : beyond;
}

void davar_floor_flight_add(davar_floor_flight_t *flight, uint32_t band,
                            const davar_floor_result_t *result)
{
    DAVAR_ASSERT(band < FLOOR_BANDS);
    if (result->why == DAVAR_FLOOR_VALUE) {
        flight->sum[band] += result->value;
        flight->windows[band]++;
    }
}

/* Standard deviation of the floor of one more flight over its mean. */
static float scatter_of_flight(const davar_floor_baseline_t *baseline, uint32_t band)
{
    const float flights = (float)baseline->flights[band];
    const float mean = baseline->mean[band];
    const float own = baseline->square[band] / ((flights - 1.0F) * mean * mean);
    const float least = FLOOR_SCATTER_LEAST * FLOOR_SCATTER_LEAST;
    const float square = ((own > least) ? own : least) * (1.0F + 1.0F / flights);
    return scaled_root_of_float(square);
}

/* Bands of a flight that is louder are louder together, so their scatter does not average out. */
void davar_floor_compare(const davar_floor_baseline_t *baseline, const davar_floor_flight_t *flight,
                         davar_floor_change_t *change)
{
    float ratio = 0.0F;
    float reach = 0.0F;
    float windows = 0.0F;
    for (uint32_t b = 0U; b < FLOOR_BANDS; b++) {
        const uint32_t flights = baseline->flights[b];
        if ((flights >= FLOOR_FLIGHTS_LEAST) && (flight->windows[b] >= FLOOR_WINDOWS_LEAST)) {
            const float weight = (float)flight->windows[b];
            ratio += flight->sum[b] / baseline->mean[b];
            reach += weight * scatter_of_flight(baseline, b) * student_of(flights - 1U);
            windows += weight;
        }
    }
    *change = (davar_floor_change_t){.factor = NAN, .high = HUGE_VALF};
    if (windows > 0.0F) {
        change->is_known = true;
        change->factor = ratio / windows;
        change->low = change->factor / (1.0F + reach / windows);
        change->high = change->factor * (1.0F + reach / windows);
    }
}

void davar_floor_baseline_add(davar_floor_baseline_t *baseline, const davar_floor_flight_t *flight)
{
    for (uint32_t b = 0U; b < FLOOR_BANDS; b++) {
        if (flight->windows[b] >= FLOOR_WINDOWS_LEAST) {
            const float mean = flight->sum[b] / (float)flight->windows[b];
            const uint16_t before = baseline->flights[b];
            const uint16_t flights =
                (uint16_t)((before < FLOOR_FLIGHTS_MOST) ? (before + 1U) : before);
            const float off = mean - baseline->mean[b];
            const float forget =
                (before < FLOOR_FLIGHTS_MOST) ? 1.0F : (1.0F - 1.0F / (float)flights);
            baseline->mean[b] += off / (float)flights;
            baseline->square[b] = forget * baseline->square[b] + off * (mean - baseline->mean[b]);
            baseline->flights[b] = flights;
        }
    }
}
