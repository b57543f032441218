/** @file
 * davar - content: what a running instance consists of, to save it and to write it back.
 *
 * An instance is the caller's memory and a few fields. davar/state.h saves both in two slots of a
 * storage; use this header for another way to keep them.
 *
 * Threads: stopped. No push, take, gap or flush of the instance may run at the same time. */
#ifndef DAVAR_CONTENT_H
#define DAVAR_CONTENT_H

#include "davar/instance.h"

#ifdef __cplusplus
extern "C" {
#endif

/** The caller's memory of an instance and what its layout depends on, besides the configuration and
 * the machine. Contents fit each other only if all of that is equal. */
typedef struct {
    const davar_config_t *config; /**< of the instance */
    void *memory;                 /**< the caller's memory; it may contain pointers into itself */
    size_t bytes;                 /**< that the instance uses of it */
    uint32_t sum_bits;            /**< of the sums: 64 for _q15, 128 for _q31 and _f32 */
    bool is_float;                /**< _f32 */
} davar_layout_t;

/** The fields of an instance, without pointers. They are private. */
typedef struct {
    /** @privatesection */
    davar_window_t window;
    davar_health_t health;
    uint32_t produced;
    uint32_t seen;
    uint16_t gaps;
    bool ready;
    bool in_gap;
    bool unstable;
    uint32_t alarms_seen;
    davar_past_t past;
} davar_content_t;

/** The ids of the laws, which never change. */
typedef enum {
    DAVAR_LAW_ID_FIXED = 0,    /**< no law: the window keeps its length */
    DAVAR_LAW_ID_KURTOSIS = 1, /**< davar_law_kurtosis */
    DAVAR_LAW_ID_OR = 2,       /**< davar_law_or */
    DAVAR_LAW_ID_AND = 3,      /**< davar_law_and */
    DAVAR_LAW_ID_GLR = 4       /**< davar_law_glr_q15 or davar_law_glr_q31 */
} davar_law_id_t;

/** Returns the id of the configured law. Cost: O(1). */
davar_law_id_t davar_law_id(const davar_config_t *config);

/** States where the memory of an initialised instance is and how it is laid out. Cost: O(1). */
void davar_content_layout(const davar_t *davar, davar_layout_t *layout);

/** Copies the fields; padding becomes zero. Cost: O(1). */
void davar_content_read(const davar_t *davar, davar_content_t *content);

/** Sets the fields, after the caller copied the memory back. It sets every pointer in the memory
 * again, so the content may come from another address.
 * Fields and memory must come from one instance with an equal layout: they are not checked. An
 * instance whose memory was overwritten by anything else needs davar_reset. Cost: O(T). */
void davar_content_write(davar_t *davar, const davar_content_t *content);

#ifdef __cplusplus
}
#endif

#endif
