/* davar on a bare board - use with interrupts. A timer interrupt pushes one sample of the sensor.
 * The main loop takes results and sends them as SLCAN text over the UART. Nothing waits, and every
 * loss is counted.
 *
 *   timer interrupt -> sensor -> davar_push_q15
 *   main loop: davar_take -> davar_fit -> encoder -> SLCAN -> UART
 *
 * The sensor is a job file of one int16 channel without a cascade. Command line: image JOB PERIOD_US. The last lines
 * on the console are the counters. Exit status: see job_file.h. */
#include "board.h"
#include "job_file.h"

#include "davar/fit.h"
#include "davar/glr.h"
#include "davar/slcan.h"

#include <stdlib.h>
#include <string.h>

static job_file_t sensor;
static davar_t davar;

/* --- used by the interrupt --- */

static davar_port_block_t block; /* next samples of the sensor */
static size_t position;          /* in the block */
static uint32_t period;          /* ticks of the clock between samples */
static uint32_t last;            /* when the last sample was due */
static volatile uint32_t samples;
/* samples that were replaced before the interrupt could run */
static volatile uint32_t overruns;
static volatile bool ended;

/* Reads the next sample of the sensor. */
static bool sense(int16_t *sample, uint32_t *missing)
{
    if (position == block.count) {
        position = 0U;
        if (job_file_read(&sensor, &block) != DAVAR_PORT_READ_BLOCK) {
            block.count = 0U;
            ended = true;
            return false;
        }
        *missing += block.missing;
    }
    *sample = block.samples[0].q15[position];
    position++;
    return true;
}

/* The number of samples that became due since the last call, without the present one. */
static uint32_t late(void)
{
    const uint32_t now = board_clock();
    uint32_t count = 0U;
    for (last += period; (now - last) >= period; last += period) {
        count++;
    }
    return count;
}

void board_tick(void)
{
    int16_t sample = 0;
    uint32_t missing = 0U;
    for (uint32_t lost = ended ? 0U : late(); (lost > 0U) && sense(&sample, &missing); lost--) {
        missing++;
        overruns++;
    }
    if (ended || !sense(&sample, &missing)) {
        return;
    }
    if (missing > 0U) {
        davar_gap(&davar, missing);
    }
    davar_push_q15(&davar, &sample, 1U);
    samples++;
}

/* --- used by the main loop --- */

static davar_result_t result;
static davar_glr_report_t glr_report;
static davar_encoder_t encoder;
static davar_can_health_t health;
static char text[DAVAR_SLCAN_BYTES] = "\r"; /* ends an incomplete line of the reader */
static size_t length = 1U;                  /* of the text */
static size_t written;                      /* characters of it that are in the UART */
static uint32_t results;

static void take_health(void)
{
    const davar_health_t of_channel = davar_health(&davar);
    davar_can_health(&health, &of_channel);
    health.count[DAVAR_HEALTH_EDGES_LOST] = overruns;
}

/* Writes as many characters as the UART accepts. True while the result has more frames. */
static bool transmit(void)
{
    davar_frame_t frame;
    while ((written < length) && board_serial_put(text[written])) {
        written++;
    }
    if (written < length) {
        return true;
    }
    written = 0U;
    length = davar_encoder_next(&encoder, &frame) ? davar_slcan_encode(&frame, text) : 0U;
    return length > 0U;
}

static void begin(void)
{
    results++;
    davar_glr_report(&davar, &glr_report);
    davar_fit(&sensor.plan, sensor.job.config.rate_hz, &result);
    (void)davar_fit_flat(&sensor.plan, sensor.job.config.rate_hz, &result);
    take_health();
    davar_encoder_begin(&encoder, &result, &glr_report, &health);
}

/* The main loop of a firmware; here it ends with the recording. It polls, because an emulator that
 * waits for an interrupt (wfi) does not count the elapsed time. */
static void run(void)
{
    while (!ended) {
        if (!transmit() && davar_take(&davar, &result)) {
            begin();
        }
    }
}

/* The interrupt pushes no more samples, so the remaining results may be flushed. */
static void finish(void)
{
    do {
        while (transmit()) {
        }
        const bool more =
            davar_take(&davar, &result) || (davar_flush(&davar) && davar_take(&davar, &result));
        if (!more) {
            break;
        }
        begin();
    } while (true);
    take_health();
    davar_encoder_finish(&encoder, &health);
    while (transmit()) {
    }
}

static void report(void)
{
    board_figure("samples", samples);
    board_figure("overruns", overruns);
    board_figure("results", results);
    board_figure("missed", davar_health(&davar).missed);
}

int main(void)
{
    static char command[256];
    char *words[3];
    if (board_words(command, sizeof command, words, 3U) != 3U) {
        return JOB_NO_FILE;
    }
    const int opened = job_file_open(&sensor, words[1], &davar);
    if (opened != JOB_DONE) {
        return opened;
    }
    if ((sensor.job.channels != 1U) || (sensor.job.number != DAVAR_PORT_Q15) ||
        (job_file_cascade(&sensor, 0U) != NULL) ||
        !davar_encoder_init(&encoder, &sensor.job.config, DAVAR_CAN_BASE, 0U,
                            DAVAR_SEND_ADEV | DAVAR_SEND_COEFFICIENTS)) {
        return JOB_UNKNOWN;
    }
    const uint32_t period_us = (uint32_t)strtoul(words[2], NULL, 10);
    period = period_us * BOARD_CLOCK_PER_US;
    last = board_clock();
    board_tick_every(period_us);
    run();
    finish();
    report();
    return JOB_DONE;
}
