/* davar - saves and restores an instance. The caller's memory is saved as it is, pointers included;
 * restoring lays it out again, which overwrites every pointer. */
#include "davar/state.h"

#include "core/instance.h"
#include "number/machine.h"

#include "davar/davar.h"
#include "davar/version.h"

#include <string.h>

#define MAGIC 0x52564144U         /* "DAVR" */
#define MAGIC_SWAPPED 0x44415652U /* written with the other byte order */
#define FORMAT 5U
#define SLOTS 2U

/* Before each image. `check` covers the fields above it and the payload. */
typedef struct {
    uint32_t magic;
    uint32_t bytes;       /* of the payload */
    uint32_t fingerprint; /* of format, number type, configuration and machine */
    uint32_t order;       /* one more than that of the previous image, modulo 2^32 */
    uint32_t check;
} header_t;

/* The instance without its pointers. */
typedef struct {
    davar_window_t window;
    davar_health_t health;
    uint32_t produced;
    uint32_t seen;
    uint16_t gaps;
    bool ready;
    bool in_gap;
    bool unstable;
    uint32_t alarms_seen;
} saved_t;

/* CRC-32 (IEEE 802.3, reflected), four bits at a time. */
DAVAR_RARE static uint32_t check_of(uint32_t check, const void *data, size_t bytes)
{
    static const uint32_t table[16] = {
        0x00000000U, 0x1DB71064U, 0x3B6E20C8U, 0x26D930ACU, 0x76DC4190U, 0x6B6B51F4U,
        0x4DB26158U, 0x5005713CU, 0xEDB88320U, 0xF00F9344U, 0xD6D6A3E8U, 0xCB61B38CU,
        0x9B64C2B0U, 0x86D3D2D4U, 0xA00AE278U, 0xBDBDF21CU,
    };
    const unsigned char *const byte = data;
    uint32_t crc = ~check;
    for (size_t i = 0U; i < bytes; i++) {
        crc = (crc >> 4U) ^ table[(crc ^ byte[i]) & 15U];
        crc = (crc >> 4U) ^ table[(crc ^ ((uint32_t)byte[i] >> 4U)) & 15U];
    }
    return ~crc;
}

DAVAR_RARE static uint32_t check_of_u32(uint32_t check, uint32_t value)
{
    const unsigned char bytes[4] = {(unsigned char)value, (unsigned char)(value >> 8U),
                                    (unsigned char)(value >> 16U), (unsigned char)(value >> 24U)};
    return check_of(check, bytes, sizeof bytes);
}

DAVAR_RARE static uint32_t header_check(const header_t *header)
{
    return check_of(0U, header, offsetof(header_t, check));
}

DAVAR_RARE static uint32_t payload_check(const header_t *header, const saved_t *saved,
                                         const void *memory, size_t bytes)
{
    return check_of(check_of(header_check(header), saved, sizeof *saved), memory, bytes);
}

static uint32_t check_of_f64(uint32_t check, const double *value)
{
    uint64_t bits;
    memcpy(&bits, value, sizeof bits);
    return check_of_u32(check_of_u32(check, (uint32_t)bits), (uint32_t)(bits >> 32U));
}

/* Adds a field to the fingerprint, by its kind. */
#define CHECK_F64(check, value) check_of_f64(check, &(value))
#define CHECK_U32(check, value) check_of_u32(check, value)
#define CHECK_U16(check, value) check_of_u32(check, value)
#define CHECK_I16(check, value) check_of_u32(check, (uint32_t)(value))
#define CHECK_U8(check, value) check_of_u32(check, value)
#define CHECK_BOOL(check, value) check_of_u32(check, (uint32_t)(value))
#define CHECK_MODE(check, value) check_of_u32(check, (uint32_t)(value))
#define CHECK_ENGINE(check, value) check_of_u32(check, (uint32_t)(value))

/* Covers everything that an image depends on. Field by field, because padding is undefined. */
DAVAR_RARE static uint32_t fingerprint(const davar_t *davar)
{
    const davar_config_t *const config = davar->config;
    const uint32_t build[] = {FORMAT,
                              DAVAR_VERSION_MAJOR,
                              DAVAR_VERSION_MINOR,
                              DAVAR_VERSION_PATCH,
                              (uint32_t)sizeof(void *),
                              (uint32_t)sizeof(saved_t),
                              davar->number->sum_bits,
                              davar->is_float ? 1U : 0U,
                              davar_law_id(config)};
    uint32_t check = 0U;
    for (size_t i = 0U; i < (sizeof build / sizeof build[0]); i++) {
        check = check_of_u32(check, build[i]);
    }
#define FIELD(member, kind, low, high, usual, status, option, unit, help)                          \
    check = CHECK_##kind(check, config->member);
#include "davar/config_fields.inc"
    return check_of(check, config->taus, config->tau_count * sizeof config->taus[0]);
}

DAVAR_RARE static size_t memory_bytes(const davar_t *davar)
{
    return is_wide(davar) ? davar_q31_memory_size(davar->config)
                          : davar_q15_memory_size(davar->config);
}

DAVAR_RARE size_t davar_state_bytes(const davar_t *davar)
{
    return sizeof(header_t) + sizeof(saved_t) + memory_bytes(davar);
}

/* --- reading ---------------------------------------------------------------------------------- */

DAVAR_RARE static uint32_t swapped(uint32_t value)
{
    return (value >> 24U) | ((value >> 8U) & 0xFF00U) | ((value << 8U) & 0xFF0000U) |
           (value << 24U);
}

/* Reads a whole slot. False: it is unreadable, as half-written flash often is. An image of the
 * other byte order may be whole; its magic stays swapped, so that it never fits. */
DAVAR_RARE static bool read_slot(const davar_storage_t *storage, unsigned slot, header_t *header,
                                 bool *whole)
{
    size_t offset = slot * storage->slot_bytes;
    *whole = false;
    if (!storage->read(storage->context, offset, header, sizeof *header)) {
        return false;
    }
    uint32_t check = header_check(header); /* of the stored bytes */
    if (header->magic == MAGIC_SWAPPED) {
        header->bytes = swapped(header->bytes);
        header->order = swapped(header->order);
        header->check = swapped(header->check);
    } else if (header->magic != MAGIC) {
        return true;
    }
    if (header->bytes > (storage->slot_bytes - sizeof *header)) {
        return true;
    }
    offset += sizeof *header;
    for (size_t left = header->bytes; left > 0U;) {
        unsigned char part[64];
        const size_t bytes = (left < sizeof part) ? left : sizeof part;
        if (!storage->read(storage->context, offset, part, bytes)) {
            return false;
        }
        check = check_of(check, part, bytes);
        offset += bytes;
        left -= bytes;
    }
    *whole = (check == header->check);
    return true;
}

/* The content of both slots. */
typedef struct {
    header_t header[SLOTS];
    bool whole[SLOTS];
    unsigned newest; /* whole image; 1 if there is none, so that slot 0 is next */
} slots_t;

/* False: neither slot is readable. An unreadable slot has no whole image. */
DAVAR_RARE static bool read_slots(const davar_storage_t *storage, slots_t *slots)
{
    memset(slots, 0, sizeof *slots);
    const bool first = read_slot(storage, 0U, &slots->header[0], &slots->whole[0]);
    const bool second = read_slot(storage, 1U, &slots->header[1], &slots->whole[1]);
    const bool first_is_newer = (int32_t)(slots->header[0].order - slots->header[1].order) > 0;
    slots->newest = (slots->whole[0] && (first_is_newer || !slots->whole[1])) ? 0U : 1U;
    return first || second;
}

/* False: the instance is as after init. Hazard: a second reading may differ from the first. So the
 * check covers the copy in memory, before anything of it is used. */
DAVAR_RARE static bool read_payload(davar_t *davar, const davar_storage_t *storage, unsigned slot,
                                    const header_t *header)
{
    const size_t offset = (slot * storage->slot_bytes) + sizeof *header;
    const size_t bytes = memory_bytes(davar);
    saved_t saved;
    if (!storage->read(storage->context, offset, &saved, sizeof saved) ||
        !storage->read(storage->context, offset + sizeof saved, davar->stages, bytes) ||
        (payload_check(header, &saved, davar->stages, bytes) != header->check)) {
        davar_reset(davar);
        return false;
    }
    davar->window = saved.window;
    davar->health = saved.health;
    davar->produced = saved.produced;
    davar->seen = saved.seen;
    davar->ready = saved.ready;
    davar->in_gap = saved.in_gap;
    davar->unstable = saved.unstable;
    davar->alarms_seen = saved.alarms_seen;
    if (is_wide(davar)) {
        davar_q31_resume(davar);
    } else {
        davar_q15_resume(davar);
    }
    davar->gaps.count = saved.gaps;
    return true;
}

DAVAR_RARE davar_status_t davar_state_restore(davar_t *davar, const davar_storage_t *storage)
{
    const size_t bytes = davar_state_bytes(davar);
    const uint32_t own = fingerprint(davar);
    slots_t slots;
    bool unsteady = false;
    if ((storage->slot_bytes < bytes) || !read_slots(storage, &slots)) {
        return DAVAR_ERR_STATE_STORAGE;
    }
    for (unsigned i = 0U; i < SLOTS; i++) {
        const unsigned slot = slots.newest ^ i;
        const header_t *const header = &slots.header[slot];
        if (slots.whole[slot] && (header->magic == MAGIC) &&
            ((sizeof *header + header->bytes) == bytes) && (header->fingerprint == own)) {
            if (read_payload(davar, storage, slot, header)) {
                return DAVAR_OK;
            }
            unsteady = true;
        }
    }
    if (unsteady) {
        return DAVAR_ERR_STATE_STORAGE;
    }
    return (slots.whole[0] || slots.whole[1]) ? DAVAR_ERR_STATE_FOREIGN : DAVAR_ERR_STATE_NONE;
}

/* --- writing ---------------------------------------------------------------------------------- */

DAVAR_RARE davar_status_t davar_state_save(const davar_t *davar, const davar_storage_t *storage)
{
    slots_t slots;
    if ((storage->slot_bytes < davar_state_bytes(davar)) || !read_slots(storage, &slots)) {
        return DAVAR_ERR_STATE_STORAGE;
    }
    saved_t saved;
    memset(&saved, 0, sizeof saved); /* its padding is saved too */
    saved.window = davar->window;
    saved.health = davar->health;
    saved.produced = davar->produced;
    saved.seen = davar->seen;
    saved.gaps = davar->gaps.count;
    saved.ready = davar->ready;
    saved.in_gap = davar->in_gap;
    saved.unstable = davar->unstable;
    saved.alarms_seen = davar->alarms_seen;
    const size_t bytes = memory_bytes(davar);
    const uint32_t order = slots.whole[slots.newest] ? (slots.header[slots.newest].order + 1U) : 0U;
    header_t header = {MAGIC, (uint32_t)(sizeof saved + bytes), fingerprint(davar), order, 0U};
    header.check = payload_check(&header, &saved, davar->stages, bytes);
    const size_t at = (slots.newest ^ 1U) * storage->slot_bytes;
    const bool written =
        storage->write(storage->context, at + sizeof header, &saved, sizeof saved) &&
        storage->write(storage->context, at + sizeof header + sizeof saved, davar->stages, bytes) &&
        storage->write(storage->context, at, &header, sizeof header);
    return written ? DAVAR_OK : DAVAR_ERR_STATE_STORAGE;
}
