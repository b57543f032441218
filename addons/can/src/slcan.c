/* davar - SLCAN text. */
#include "davar/slcan.h"

#define HEAD 5U /* t5D08 */
#define STAMP 4U

static size_t put_hex(char *text, size_t at, uint32_t value, uint32_t digits)
{
    static const char hex[] = "0123456789ABCDEF";
    for (uint32_t i = digits; i > 0U; i--) {
        text[at] = hex[(value >> (4U * (i - 1U))) & 15U];
        at++;
    }
    return at;
}

size_t davar_slcan_encode(const davar_frame_t *frame, char *text)
{
    DAVAR_ASSERT(frame->length <= 8U);
    text[0] = 't';
    size_t at = put_hex(text, 1U, frame->identifier, 3U);
    at = put_hex(text, at, frame->length, 1U);
    for (uint32_t i = 0U; i < frame->length; i++) {
        at = put_hex(text, at, frame->data[i], 2U);
    }
    text[at] = '\r';
    return at + 1U;
}

/* Value of a hex digit; 16 or more if it is not one. */
static uint32_t digit(char c)
{
    if ((c >= '0') && (c <= '9')) {
        return (uint32_t)(c - '0');
    }
    const char upper = (char)(c & ~0x20);
    return ((upper >= 'A') && (upper <= 'F')) ? (uint32_t)(upper - 'A') + 10U : 16U;
}

static bool get_hex(const char *text, uint32_t digits, uint32_t *value)
{
    *value = 0U;
    for (uint32_t i = 0U; i < digits; i++) {
        const uint32_t one = digit(text[i]);
        if (one > 15U) {
            return false;
        }
        *value = (*value << 4U) | one;
    }
    return true;
}

static bool get_head(const char *text, size_t length, davar_frame_t *frame)
{
    uint32_t identifier = 0U;
    uint32_t bytes = 0U;
    if ((length < HEAD) || (text[0] != 't') || !get_hex(text + 1, 3U, &identifier) ||
        !get_hex(text + 4, 1U, &bytes)) {
        return false;
    }
    *frame = (davar_frame_t){.identifier = (uint16_t)identifier, .length = (uint8_t)bytes};
    return (identifier <= DAVAR_CAN_LAST_ID) && (bytes <= 8U);
}

bool davar_slcan_decode(const char *text, size_t length, davar_frame_t *frame)
{
    if (!get_head(text, length, frame)) {
        return false;
    }
    const size_t bare = HEAD + 2U * (size_t)frame->length;
    if ((length != bare) && (length != bare + STAMP)) {
        return false;
    }
    for (uint32_t i = 0U; i < frame->length; i++) {
        uint32_t byte = 0U;
        if (!get_hex(text + HEAD + 2U * (size_t)i, 2U, &byte)) {
            return false;
        }
        frame->data[i] = (uint8_t)byte;
    }
    uint32_t stamp = 0U;
    return (length == bare) || get_hex(text + bare, STAMP, &stamp);
}
