/* davar tests - frames and SLCAN text of any bytes. Decoded values are within the ranges of
 * codec.h, a wrong checksum or length is never accepted, and a frame survives conversion to text
 * and back. */
#include "davar_decode.h"
#include "davar_slcan.h"
#include "fuzzing.h"

#include <math.h>
#include <string.h>

/* CRC-8/SAE-J1850 again, bit by bit. */
static uint8_t crc_of(const davar_frame_t *frame)
{
    uint8_t crc = 0xFFU;
    for (unsigned i = 0U; i < (frame->length + 1U); i++) {
        const unsigned identifier = (i == 0U) ? frame->identifier & 0xFFU : frame->identifier >> 8U;
        crc = (uint8_t)(crc ^ ((i < 2U) ? identifier : frame->data[i - 1U]));
        for (unsigned bit = 0U; bit < 8U; bit++) {
            crc = (uint8_t)(((crc & 0x80U) != 0U) ? ((unsigned)crc << 1U) ^ 0x1DU
                                                  : (unsigned)crc << 1U);
        }
    }
    return (uint8_t)~crc;
}

static void check_value(const davar_wire_t *wire)
{
    REQUIRE((wire->message < DAVAR_MESSAGE_COUNT) && (wire->counter <= 15U));
    REQUIRE((wire->noise == DAVAR_NOISE_UNKNOWN) ||
            ((wire->noise <= DAVAR_NOISE_FILTERED) && isnan(wire->value)));
    const davar_message_t message = wire->message;
    if ((message == DAVAR_MESSAGE_ARW) || (message == DAVAR_MESSAGE_ADEV)) {
        REQUIRE(is_magnitude(wire->value));
    } else if (message == DAVAR_MESSAGE_STATE) {
        REQUIRE((wire->window_samples > 0U) && (wire->result <= 15U));
    } else if (message == DAVAR_MESSAGE_HEALTH) {
        REQUIRE(wire->index < DAVAR_HEALTH_COUNT);
    } else if (message == DAVAR_MESSAGE_RESULT_FD) {
        for (unsigned i = 0U; i < DAVAR_FD_TAUS; i++) {
            REQUIRE(is_magnitude(wire->adev[i]));
        }
        for (unsigned i = 0U; i < DAVAR_COEFFICIENT_COUNT; i++) {
            REQUIRE(is_magnitude(wire->coefficient[i]));
        }
    } else if (message == DAVAR_MESSAGE_CHANGE) {
        REQUIRE((wire->change_m <= 4095U) && (wire->cut_age_samples < (UINT32_C(1) << 20U)));
        REQUIRE((wire->index == (uint8_t)DAVAR_CHANGE_CUT) || is_magnitude(wire->value));
    } else {
        REQUIRE((message != DAVAR_MESSAGE_END) || (wire->index > 0U));
    }
}

static void check_frame(bytes_t *bytes)
{
    davar_frame_t frame = {.identifier = (uint16_t)(DAVAR_WIRE_BASE + byte(bytes))};
    davar_wire_t wire;
    const uint8_t how = byte(bytes);
    static const uint8_t lengths[4] = {8U, 64U, 8U, 0U};
    frame.length = lengths[how % 4U];
    frame.length = ((how % 4U) == 3U) ? (uint8_t)between(bytes, 0U, 64U) : frame.length;
    for (unsigned i = 0U; i < frame.length; i++) {
        frame.data[i] = byte(bytes);
    }
    REQUIRE((frame.length == 0U) || (davar_frame_crc(&frame) == crc_of(&frame)));
    if ((how & 0x80U) == 0U) {
        frame.data[0] = crc_of(&frame);
    }
    memset(&wire, 0xA5, sizeof wire);
    if (davar_decode(&frame, DAVAR_WIRE_BASE, &wire) == DAVAR_DECODED) {
        REQUIRE((frame.length == 8U) || (frame.length == 64U));
        REQUIRE(frame.data[0] == crc_of(&frame));
        check_value(&wire);
    }
}

static void check_text(const char *text, size_t size)
{
    davar_frame_t frame;
    davar_frame_t again;
    /* exactly the stated length, so that access to a further byte is detected */
    char *const own = malloc(size + 1U);
    REQUIRE(own != NULL);
    memcpy(own, text, size);
    char *const exact = realloc(own, (size > 0U) ? size : 1U);
    REQUIRE(exact != NULL);
    if (davar_slcan_decode(exact, size, &frame)) {
        char line[DAVAR_SLCAN_BYTES];
        REQUIRE((frame.length <= 8U) && (frame.identifier <= DAVAR_WIRE_LAST_ID));
        const size_t length = davar_slcan_encode(&frame, line);
        REQUIRE((length == (6U + (2U * (size_t)frame.length))) && (line[length - 1U] == '\r'));
        REQUIRE(davar_slcan_decode(line, length - 1U, &again));
        REQUIRE((again.identifier == frame.identifier) && (again.length == frame.length));
        REQUIRE(memcmp(again.data, frame.data, frame.length) == 0);
        REQUIRE((size == (length - 1U)) || (size == (length + 3U)));
    }
    free(exact);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    bytes_t bytes = {data, data + size};
    check_frame(&bytes);
    check_text((size > 0U) ? (const char *)data : "", size);
    return 0;
}
