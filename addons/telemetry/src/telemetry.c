/* davar - telemetry: the packets of a result, and what they have in common. */
#include "davar/glr.h"

#include "number/real.h"
#include "packet.h"

#include <math.h>

#define SECOND_US 1000000U

uint8_t davar_axis_letter(uint8_t channel)
{
    return (uint8_t)((channel < 3U) ? ('X' + channel) : ('0' + channel));
}

static double of_coefficient(const davar_result_t *result, uint32_t quantity)
{
    static const uint8_t kinds[3] = {DAVAR_ANGLE_RANDOM_WALK, DAVAR_BIAS_INSTABILITY,
                                     DAVAR_RATE_RANDOM_WALK};
    const davar_coefficient_t *found = &result->coefficient[kinds[quantity / 3U]];
    switch (quantity % 3U) {
    case 0U:
        return davar_single_magnitude(found->value);
    case 1U:
        return davar_single_magnitude(found->low);
    default:
        return davar_single_limit(found->high);
    }
}

static double quantity_of(const davar_telemetry_t *telemetry, quantity_t quantity)
{
    const davar_result_t *result = telemetry->result;
    if (quantity < QUANTITY_RR) {
        return of_coefficient(result, (uint32_t)quantity);
    }
    const double others[] = {result->coefficient[DAVAR_RATE_RAMP].value,
                             result->coefficient[DAVAR_QUANTIZATION].value, result->kurtosis,
                             telemetry->rate_hz};
    return davar_single_magnitude(others[(uint32_t)quantity - (uint32_t)QUANTITY_RR]);
}

uint32_t davar_quantity(const davar_telemetry_t *telemetry, quantity_t quantity)
{
    return davar_single_bits(quantity_of(telemetry, quantity));
}

uint8_t davar_quantity_state(const davar_telemetry_t *telemetry)
{
    const davar_result_t *const result = telemetry->result;
    const davar_glr_report_t *const report = telemetry->report;
    uint32_t state = ((uint32_t)result->noise & 7U) | (result->unstable ? 8U : 0U);
    if (report != NULL) {
        state |= (report->young ? 16U : 0U) | (report->alarm ? 32U : 0U);
    }
    return (uint8_t)state;
}

void davar_packet_put(davar_packet_t *packet, uint32_t value, uint32_t bytes)
{
    uint32_t rest = value;
    for (uint32_t i = 0U; i < bytes; i++) {
        packet->data[packet->length] = (uint8_t)rest;
        packet->length++;
        rest >>= 8U;
    }
}

void davar_packet_put_time(davar_packet_t *packet, uint64_t time_us)
{
    davar_packet_put(packet, (uint32_t)time_us, 4U);
    davar_packet_put(packet, (uint32_t)(time_us >> 32U), 4U);
}

void davar_packet_put_text(davar_packet_t *packet, const char *text)
{
    for (uint32_t i = 0U; text[i] != '\0'; i++) {
        davar_packet_put(packet, (uint8_t)text[i], 1U);
    }
}

void davar_packet_put_quantities(davar_packet_t *packet, const davar_telemetry_t *telemetry)
{
    for (uint32_t i = 0U; i < (uint32_t)QUANTITY_COUNT; i++) {
        davar_packet_put(packet, davar_quantity(telemetry, (quantity_t)i), 4U);
    }
}

void davar_packet_put_result(davar_packet_t *packet, const davar_telemetry_t *telemetry)
{
    const davar_result_t *result = telemetry->result;
    davar_packet_put(packet, (uint32_t)result->epoch, 4U);
    davar_packet_put(packet, result->window_samples, 4U);
    davar_packet_put_quantities(packet, telemetry);
    davar_packet_put(packet, telemetry->from.channel, 1U);
    davar_packet_put(packet, davar_quantity_state(telemetry), 1U);
}

void davar_packet_put_status(davar_packet_t *packet, uint32_t uptime_s, uint32_t last)
{
    davar_packet_put(packet, uptime_s, 4U);
    davar_packet_put(packet, 0U, 3U); /* health: good; mode: operational; nothing of a vendor */
    davar_packet_put(packet, last, 1U);
}

bool davar_telemetry_init(davar_telemetry_t *telemetry, const davar_dialect_t *dialect,
                          const davar_telemetry_address_t *from, double rate_hz)
{
    DAVAR_ASSERT((telemetry != NULL) && (dialect != NULL) && (from != NULL));
    if ((from->channel > DAVAR_TELEMETRY_CHANNEL_LAST) || (from->node == 0U) ||
        !dialect->accepts(from)) {
        return false;
    }
    *telemetry = (davar_telemetry_t){
        .dialect = dialect, .from = *from, .rate_hz = rate_hz, .index = UINT8_MAX};
    return true;
}

bool davar_telemetry_set_channel(davar_telemetry_t *telemetry, uint8_t channel)
{
    DAVAR_ASSERT(telemetry != NULL);
    if (channel > DAVAR_TELEMETRY_CHANNEL_LAST) {
        return false;
    }
    telemetry->from.channel = channel;
    return true;
}

void davar_telemetry_floor(davar_telemetry_t *telemetry, const davar_floor_result_t *floor)
{
    DAVAR_ASSERT(telemetry != NULL);
    telemetry->floor = floor;
}

void davar_telemetry_begin(davar_telemetry_t *telemetry, const davar_result_t *result,
                           const davar_glr_report_t *report, uint64_t time_us)
{
    DAVAR_ASSERT((telemetry != NULL) && (result != NULL));
    telemetry->result = result;
    telemetry->report = report;
    telemetry->time_us = time_us;
    telemetry->index = 0U;
}

bool davar_telemetry_next(davar_telemetry_t *telemetry, davar_packet_t *packet)
{
    DAVAR_ASSERT((telemetry != NULL) && (packet != NULL));
    const davar_dialect_t *const dialect = telemetry->dialect;
    const uint32_t floors = (telemetry->floor != NULL) ? dialect->floors : 0U;
    if (telemetry->index >= dialect->packets + floors) {
        return false;
    }
    *packet = (davar_packet_t){0};
    dialect->fill(telemetry, packet);
    telemetry->index++;
    telemetry->sequence++;
    return true;
}

bool davar_telemetry_heartbeat(davar_telemetry_t *telemetry, uint64_t time_us,
                               davar_packet_t *packet)
{
    DAVAR_ASSERT((telemetry != NULL) && (packet != NULL));
    const uint32_t late_us = (uint32_t)time_us - telemetry->heartbeat_us; /* early: about 2^32 */
    if (late_us >= (0U - SECOND_US)) {
        return false;
    }
    *packet = (davar_packet_t){0};
    telemetry->dialect->fill_heartbeat(telemetry, (uint32_t)(time_us / SECOND_US), packet);
    telemetry->heartbeat_us += SECOND_US + ((late_us < SECOND_US) ? 0U : late_us);
    telemetry->heartbeats++;
    return true;
}
