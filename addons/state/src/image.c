/* davar - images of a state in two slots: the newest whole one survives a loss of power. */
#include "image.h"

#include "number/machine.h"

#include <string.h>

#define MAGIC 0x52564144U         /* "DAVR" */
#define MAGIC_SWAPPED 0x44415652U /* written with the other byte order */
#define SLOTS 2U

/* Before each image. `check` covers the fields above it and the payload. */
typedef struct {
    uint32_t magic;
    uint32_t bytes;       /* of the payload */
    uint32_t fingerprint; /* of format, number type, configuration and machine */
    uint32_t order;       /* one more than that of the previous image, modulo 2^32 */
    uint32_t check;
} header_t;

/* CRC-32 (IEEE 802.3, reflected), four bits at a time. */
DAVAR_RARE uint32_t davar_image_check(uint32_t check, const void *data, size_t bytes)
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

DAVAR_RARE uint32_t davar_image_check_u32(uint32_t check, uint32_t value)
{
    const unsigned char bytes[4] = {(unsigned char)value, (unsigned char)(value >> 8U),
                                    (unsigned char)(value >> 16U), (unsigned char)(value >> 24U)};
    return davar_image_check(check, bytes, sizeof bytes);
}

DAVAR_RARE static uint32_t header_check(const header_t *header)
{
    return davar_image_check(0U, header, offsetof(header_t, check));
}

DAVAR_RARE uint32_t davar_image_check_f64(uint32_t check, const double *value)
{
    uint64_t bits;
    memcpy(&bits, value, sizeof bits);
    return davar_image_check_u32(davar_image_check_u32(check, (uint32_t)bits),
                                 (uint32_t)(bits >> 32U));
}

DAVAR_RARE static uint32_t payload_check(const header_t *header, const davar_image_t *image)
{
    const uint32_t check =
        davar_image_check(header_check(header), image->saved, image->saved_bytes);
    return davar_image_check(check, image->memory, image->memory_bytes);
}

DAVAR_RARE size_t davar_image_bytes(size_t saved_bytes, size_t memory_bytes)
{
    return sizeof(header_t) + saved_bytes + memory_bytes;
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
        check = davar_image_check(check, part, bytes);
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

/* False: neither slot is readable. An unreadable slot has no intact image. */
DAVAR_RARE static bool read_slots(const davar_storage_t *storage, slots_t *slots)
{
    memset(slots, 0, sizeof *slots);
    const bool first = read_slot(storage, 0U, &slots->header[0], &slots->whole[0]);
    const bool second = read_slot(storage, 1U, &slots->header[1], &slots->whole[1]);
    const bool first_is_newer = (int32_t)(slots->header[0].order - slots->header[1].order) > 0;
    slots->newest = (slots->whole[0] && (first_is_newer || !slots->whole[1])) ? 0U : 1U;
    return first || second;
}

/* Hazard: a second reading may differ from the first. So the check covers the copy in memory,
 * before anything of it is used. */
DAVAR_RARE static bool read_payload(const davar_image_t *image, const davar_storage_t *storage,
                                    unsigned slot, const header_t *header)
{
    const size_t offset = (slot * storage->slot_bytes) + sizeof *header;
    return storage->read(storage->context, offset, image->saved, image->saved_bytes) &&
           storage->read(storage->context, offset + image->saved_bytes, image->memory,
                         image->memory_bytes) &&
           (payload_check(header, image) == header->check);
}

/* An image of this size, version, configuration and machine? */
static bool is_own(const header_t *header, const davar_image_t *image, size_t bytes)
{
    return (header->magic == MAGIC) && ((sizeof *header + header->bytes) == bytes) &&
           (header->fingerprint == image->fingerprint);
}

DAVAR_RARE davar_state_status_t davar_image_restore(const davar_image_t *image,
                                                    const davar_storage_t *storage)
{
    const size_t bytes = davar_image_bytes(image->saved_bytes, image->memory_bytes);
    slots_t slots;
    bool unsteady = false;
    if ((storage->slot_bytes < bytes) || !read_slots(storage, &slots)) {
        return DAVAR_STATE_ERR_STORAGE;
    }
    for (unsigned i = 0U; i < SLOTS; i++) {
        const unsigned slot = slots.newest ^ i;
        const header_t *const header = &slots.header[slot];
        if (slots.whole[slot] && is_own(header, image, bytes)) {
            if (read_payload(image, storage, slot, header)) {
                return DAVAR_STATE_OK;
            }
            unsteady = true;
        }
    }
    if (unsteady) {
        return DAVAR_STATE_ERR_STORAGE;
    }
    return (slots.whole[0] || slots.whole[1]) ? DAVAR_STATE_ERR_FOREIGN : DAVAR_STATE_ERR_NONE;
}

/* --- writing ---------------------------------------------------------------------------------- */

DAVAR_RARE davar_state_status_t davar_image_save(const davar_image_t *image,
                                                 const davar_storage_t *storage)
{
    slots_t slots;
    const size_t bytes = davar_image_bytes(image->saved_bytes, image->memory_bytes);
    if ((storage->slot_bytes < bytes) || !read_slots(storage, &slots)) {
        return DAVAR_STATE_ERR_STORAGE;
    }
    const uint32_t order = slots.whole[slots.newest] ? (slots.header[slots.newest].order + 1U) : 0U;
    header_t header = {MAGIC, (uint32_t)(image->saved_bytes + image->memory_bytes),
                       image->fingerprint, order, 0U};
    header.check = payload_check(&header, image);
    const size_t at = (slots.newest ^ 1U) * storage->slot_bytes;
    const size_t payload = at + sizeof header;
    const bool written =
        storage->write(storage->context, payload, image->saved, image->saved_bytes) &&
        storage->write(storage->context, payload + image->saved_bytes, image->memory,
                       image->memory_bytes) &&
        storage->write(storage->context, at, &header, sizeof header);
    return written ? DAVAR_STATE_OK : DAVAR_STATE_ERR_STORAGE;
}

/* --- the reasons as text ---------------------------------------------------------------------- */

const char *davar_state_status_text(davar_state_status_t status)
{
    static const char *const text[] = {
        [DAVAR_STATE_OK] = "ok",
        [DAVAR_STATE_ERR_STORAGE] = "storage slot too small, or storage failed",
        [DAVAR_STATE_ERR_NONE] = "no intact image of a state",
        [DAVAR_STATE_ERR_FOREIGN] =
            "state of another version, number type, configuration or machine",
    };
    return ((size_t)status < (sizeof text / sizeof text[0])) ? text[status] : "unknown status";
}
