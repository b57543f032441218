/* davar tests - the drivers of examples/stm32_can with registers in memory. This simulates the
 * controller after the reference manuals: mailboxes that empty at times, a bus that goes off and
 * returns. Prints every frame that reaches the bus (candump notation), then the counters. can_probe
 * bxcan|fdcan SEED */
#include "bxcan.h"
#include "can_sender.h"
#include "fdcan.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define OFF_FROM 4000U /* steps at which the bus is off */
#define OFF_TO 4400U
#define STEPS 12000U

static uint32_t state;

static uint32_t draw(void)
{
    state = (state * 1664525U) + 1013904223U;
    return state >> 16U;
}

static void print(uint32_t identifier, uint32_t length, const volatile uint32_t *words, bool fd)
{
    printf("%03X#", identifier);
    for (uint32_t i = 0U; i < length; i++) {
        printf("%02X", (words[i / 4U] >> (8U * (i % 4U))) & 0xFFU);
    }
    printf("%s\n", fd ? " fd" : "");
}

/* --- bxCAN --- */

static bxcan_registers_t bx;
static uint32_t order[3]; /* mailboxes in the order of their requests (TXFP) */
static uint32_t requested;

static bool is_waiting(uint32_t box)
{
    bool found = false;
    for (uint32_t i = 0U; i < requested; i++) {
        found = found || (order[i] == box);
    }
    return found;
}

static void step_bxcan(bool off, bool sends)
{
    const bool asked = (bx.MCR & 1U) != 0U;
    bx.MSR = asked ? 1U : 0U; /* INAK follows INRQ */
    bx.ESR = off ? 4U : 0U;
    for (uint32_t box = 0U; box < 3U; box++) {
        if (((bx.mailbox[box].TIR & 1U) != 0U) && !is_waiting(box)) {
            order[requested] = box;
            requested++;
        }
    }
    if (sends && !off && !asked && (requested > 0U)) {
        const uint32_t box = order[0];
        const uint32_t words[2] = {bx.mailbox[box].TDLR, bx.mailbox[box].TDHR};
        print(bx.mailbox[box].TIR >> 21U, bx.mailbox[box].TDTR & 15U, words, false);
        bx.mailbox[box].TIR &= ~UINT32_C(1);
        requested--;
        order[0] = order[1];
        order[1] = order[2];
    }
    uint32_t empty = 0U;
    uint32_t next = 0U;
    for (uint32_t box = 3U; box > 0U; box--) {
        if (!is_waiting(box - 1U)) {
            empty |= UINT32_C(1) << (26U + box - 1U);
            next = box - 1U;
        }
    }
    bx.TSR = empty | (next << 24U);
}

/* --- FDCAN --- */

static fdcan_registers_t fd;
static fdcan_buffer_t buffers[3];
static uint32_t put;
static uint32_t get;
static uint32_t level;

static void step_fdcan(bool off, bool sends)
{
    static bool was_off;
    if (off && !was_off) {
        fd.CCCR |= 1U; /* the controller leaves the bus */
    }
    was_off = off;
    fd.PSR = off ? 0x80U : 0U;
    if (fd.TXBAR != 0U) {
        if ((fd.TXBAR != (UINT32_C(1) << put)) || (level == 3U)) {
            fprintf(stderr, "a buffer that is not the next\n");
            exit(1);
        }
        fd.TXBAR = 0U;
        put = (put + 1U) % 3U;
        level++;
    }
    if (sends && !off && ((fd.CCCR & 1U) == 0U) && (level > 0U)) {
        const bool is_fd = (buffers[get].word[1] & (UINT32_C(1) << 21U)) != 0U;
        const uint32_t code = (buffers[get].word[1] >> 16U) & 15U;
        print((buffers[get].word[0] >> 18U) & 0x7FFU, is_fd ? 64U : code, &buffers[get].word[2],
              is_fd);
        get = (get + 1U) % 3U;
        level--;
    }
    fd.TXFQS =
        (3U - level) | (get << 8U) | (put << 16U) | ((level == 3U) ? (UINT32_C(1) << 21U) : 0U);
}

/* --- main --- */

static bxcan_t bxcan;
static fdcan_t fdcan;

static bool send_bxcan(void *controller, const davar_frame_t *frame)
{
    return bxcan_send(controller, frame);
}

static bool send_fdcan(void *controller, const davar_frame_t *frame)
{
    return fdcan_send(controller, frame);
}

int main(int argc, char **argv)
{
    static const uint32_t taus[] = {1, 2, 4, 8};
    static const davar_config_t config = {
        .rate_hz = 100.0, .unit_per_count = 0.05, .stride = 100, .taus = taus, .tau_count = 4};
    const bool is_fd = (argc > 1) && (strcmp(argv[1], "fdcan") == 0);
    state = (uint32_t)strtoul(argv[argc - 1], NULL, 10);
    bool started = false;
    if (is_fd) {
        fdcan = (fdcan_t){.registers = &fd,
                          .buffers = buffers,
                          .nominal = fdcan_timing(10U, 13U, 2U),
                          .data = fdcan_data_timing(2U, 15U, 4U)};
        fdcan_start(&fdcan);
        started = can_sender_start(&config, 9U, true, send_fdcan, &fdcan);
    } else {
        bx.MCR = 0x00010002U; /* the state after a reset: asleep */
        bxcan_start(&bxcan, &bx, bxcan_timing(6U, 11U, 2U));
        started = can_sender_start(&config, 9U, false, send_bxcan, &bxcan);
    }
    if (!started) {
        return 1;
    }
    uint32_t results = 0U;
    for (uint32_t i = 0U; i < STEPS; i++) {
        const bool off = (i >= OFF_FROM) && (i < OFF_TO);
        if (is_fd) {
            step_fdcan(off, (draw() % 4U) == 0U);
            fdcan_poll(&fdcan);
        } else {
            step_bxcan(off, (draw() % 4U) == 0U);
            bxcan_poll(&bxcan);
        }
        if (((i % 100U) == 50U) && (i < (STEPS - 200U))) {
            davar_result_t result = {.epoch = results, .window_samples = 600U, .tau_count = 4U};
            const davar_health_t health = {.gaps = results};
            for (uint32_t t = 0U; t < 4U; t++) {
                result.tau[t] = (davar_adev_t){.m = taus[t],
                                               .differences = 100U,
                                               .adev = results + 0.25,
                                               .low = results,
                                               .high = results + 1.0};
            }
            can_sender_result(&result, &health, is_fd ? fdcan.bus_off : bxcan.bus_off);
            results++;
        }
        can_sender_step();
    }
    printf("results %u bus off %u timing %08X\n", results, is_fd ? fdcan.bus_off : bxcan.bus_off,
           is_fd ? fd.NBTP : bx.BTR);
    return 0;
}
