/* davar - the content of an instance, for a saved state: its fields without the pointers, and its
 * memory, which a restored instance lays out again. */
#include "davar/content.h"

#include "core/instance.h"
#include "number/machine.h"

#include <string.h>

davar_law_id_t davar_law_id(const davar_config_t *config)
{
    return (config->law == NULL) ? DAVAR_LAW_ID_FIXED : (davar_law_id_t)config->law->id;
}

DAVAR_RARE void davar_content_layout(const davar_t *davar, davar_layout_t *layout)
{
    layout->config = davar->config;
    layout->memory = davar->stages;
    layout->bytes = is_wide(davar) ? davar_q31_memory_size(davar->config)
                                   : davar_q15_memory_size(davar->config);
    layout->sum_bits = davar->number->sum_bits;
    layout->is_float = davar->is_float;
}

DAVAR_RARE void davar_content_read(const davar_t *davar, davar_content_t *content)
{
    memset(content, 0, sizeof *content);
    content->window = davar->window;
    content->health = davar->health;
    content->produced = davar->produced;
    content->seen = davar->seen;
    content->gaps = davar->gaps.count;
    content->ready = davar->ready;
    content->in_gap = davar->in_gap;
    content->unstable = davar->unstable;
    content->alarms_seen = davar->alarms_seen;
    content->past = davar->past;
}

DAVAR_RARE void davar_content_write(davar_t *davar, const davar_content_t *content)
{
    davar->window = content->window;
    davar->health = content->health;
    davar->produced = content->produced;
    davar->seen = content->seen;
    davar->ready = content->ready;
    davar->in_gap = content->in_gap;
    davar->unstable = content->unstable;
    davar->alarms_seen = content->alarms_seen;
    davar->past = content->past;
    if (is_wide(davar)) {
        davar_q31_resume(davar);
    } else {
        davar_q15_resume(davar);
    }
    davar->gaps.count = content->gaps;
}
