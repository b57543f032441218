/* davar tests - the dialects of autopilots as a filter, for Python tests that decode the packets.
 *
 *   telemetry_probe DIALECT CHANNEL NODE SYSTEM SUBJECT RATE FLOOR
 *       FLOOR 1: sends floors too; results on standard input (record_t), packets on standard output: identifier (4 bytes),
 *       length (1 byte), data
 *   telemetry_probe covariance
 *       six variances (doubles) each, 12 bytes each */
#include "davar/glr.h"
#include "davar/telemetry.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct {
    double coefficient[DAVAR_COEFFICIENT_COUNT][3]; /* value, low, high */
    double kurtosis;
    uint64_t epoch;
    uint64_t time_us;
    uint32_t window_samples;
    uint8_t noise;
    uint8_t unstable;
    uint8_t young;
    uint8_t alarm;
    float floor[3]; /* value, low, high */
    uint32_t floor_why;
} record_t;

static const struct {
    const char *name;
    const davar_dialect_t *dialect;
} DIALECTS[] = {{"mavlink", &davar_mavlink},
                {"gyro_noise", &davar_mavlink_gyro_noise},
                {"dronecan", &davar_dronecan},
                {"cyphal", &davar_cyphal}};

static const davar_dialect_t *dialect_of(const char *name)
{
    for (size_t i = 0; i < sizeof DIALECTS / sizeof DIALECTS[0]; i++) {
        if (strcmp(DIALECTS[i].name, name) == 0) {
            return DIALECTS[i].dialect;
        }
    }
    return NULL;
}

static void take(const record_t *record, davar_result_t *result)
{
    *result = (davar_result_t){.epoch = record->epoch,
                               .window_samples = record->window_samples,
                               .noise = (davar_noise_t)record->noise,
                               .unstable = record->unstable != 0U,
                               .kurtosis = record->kurtosis};
    for (size_t k = 0; k < DAVAR_COEFFICIENT_COUNT; k++) {
        const double *one = record->coefficient[k];
        result->coefficient[k] =
            (davar_coefficient_t){.value = one[0], .low = one[1], .high = one[2]};
    }
}

static void print(const davar_packet_t *packet)
{
    const uint8_t head[5] = {(uint8_t)packet->identifier, (uint8_t)(packet->identifier >> 8U),
                             (uint8_t)(packet->identifier >> 16U),
                             (uint8_t)(packet->identifier >> 24U), packet->length};
    (void)fwrite(head, 1U, sizeof head, stdout);
    (void)fwrite(packet->data, 1U, packet->length, stdout);
}

static int encode(char **argv)
{
    const davar_telemetry_address_t from = {.channel = (uint8_t)strtoul(argv[2], NULL, 10),
                                            .node = (uint8_t)strtoul(argv[3], NULL, 10),
                                            .system = (uint8_t)strtoul(argv[4], NULL, 10),
                                            .subject = (uint16_t)strtoul(argv[5], NULL, 10)};
    const davar_dialect_t *const dialect = dialect_of(argv[1]);
    davar_telemetry_t telemetry;
    davar_packet_t packet;
    davar_result_t result;
    record_t record;
    if ((dialect == NULL) ||
        !davar_telemetry_init(&telemetry, dialect, &from, strtod(argv[6], NULL))) {
        return 2;
    }
    while (fread(&record, sizeof record, 1U, stdin) == 1U) {
        take(&record, &result);
        const davar_glr_report_t report = {.young = record.young != 0U,
                                           .alarm = record.alarm != 0U};
        const davar_floor_result_t floor = {.why = (davar_floor_why_t)record.floor_why,
                                            .value = record.floor[0],
                                            .low = record.floor[1],
                                            .high = record.floor[2]};
        davar_telemetry_floor(&telemetry, (argv[7][0] == '1') ? &floor : NULL);
        davar_telemetry_begin(&telemetry, &result, &report, record.time_us);
        while (davar_telemetry_next(&telemetry, &packet)) {
            print(&packet);
        }
    }
    return 0;
}

static int covariance(void)
{
    double variance[6];
    uint8_t bytes[DAVAR_COVARIANCE_BYTES];
    while (fread(variance, sizeof variance, 1U, stdin) == 1U) {
        davar_dronecan_covariance(variance, variance + 3, bytes);
        (void)fwrite(bytes, 1U, sizeof bytes, stdout);
    }
    return 0;
}

int main(int argc, char **argv)
{
    if ((argc == 2) && (strcmp(argv[1], "covariance") == 0)) {
        return covariance();
    }
    return (argc == 8) ? encode(argv) : 2;
}
