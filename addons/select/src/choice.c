/* davar - select: which of the gyros is quieter (13.2), (13.3). */
#include "select_parts.h"

#define FAINT 0.16F         /* contrast below which no evidence grows: noise ratio 1.17 (13.2) */
#define SPREAD_MARGIN 1.07F /* true spread over the learned one (13.3) */
#define SPREAD_PRIOR 64U    /* blocks that the first spread is worth */
#define STEPS 8.0F          /* least number of blocks of a decision */

/* Noise of the chosen gyro and of another one: this block, and the mean of those before. */
typedef struct {
    float now[2];
    float recent[2];
    float mismatch; /* that common motion may have added to `now` */
} rivals_t;

/* -1 .. 1, above 0 where the second one is quieter (13.2) */
static float contrast_of(const float *noise)
{
    return (noise[0] - noise[1]) / (noise[0] + noise[1] + SELECT_LEAST);
}

/* Their totals, or their differences from the third gyro where these are least. */
static rivals_t rivals_of(const select_step_t *step, uint32_t i, uint32_t j)
{
    const davar_select_t *const select = step->select;
    rivals_t rivals = {
        {step->square[i], step->square[j]}, {select->gyro[i].recent, select->gyro[j].recent}, 0.0F};
    for (uint32_t k = 0U; k < select->config->gyros; k++) {
        if ((k != i) && (k != j) && davar_select_has(step->live, k)) {
            const davar_select_pair_t *const a = davar_select_pair(select, i, k);
            const davar_select_pair_t *const b = davar_select_pair(select, j, k);
            if ((a->recent + b->recent) < (rivals.recent[0] + rivals.recent[1])) {
                rivals = (rivals_t){{a->apart, b->apart}, {a->recent, b->recent}, step->mismatch};
            }
        }
    }
    return rivals;
}

static void gather_one(const select_step_t *step, uint32_t j)
{
    const davar_select_t *const select = step->select;
    davar_select_gyro_t *const gyro = &select->gyro[j];
    const rivals_t rivals = rivals_of(step, select->chosen, j);
    const float contrast = contrast_of(rivals.now);
    const float change = contrast - contrast_of(rivals.recent);
    gyro->spread += ((change * change) - gyro->spread) / (float)(select->blocks + SPREAD_PRIOR);
    const float least = 1.0F / (select->freedom + 1.0F);
    const float spread = (gyro->spread > least) ? gyro->spread : least;
    const float gain = (2.0F * FAINT / SPREAD_MARGIN) / spread;
    const float total = rivals.now[0] + rivals.now[1] + SELECT_LEAST;
    const float clear = contrast - (rivals.mismatch / total) - FAINT;
    const float sum =
        gyro->evidence + davar_select_lesser(gain * clear, select->threshold * (1.0F / STEPS));
    gyro->evidence = (sum > 0.0F) ? sum : 0.0F;
}

void davar_select_gather(const select_step_t *step)
{
    const davar_select_t *const select = step->select;
    const uint32_t chosen = select->chosen;
    for (uint32_t j = 0U; j < select->config->gyros; j++) {
        if (!davar_select_has(step->usable, chosen) || !davar_select_has(step->usable, j)) {
            select->gyro[j].evidence = 0.0F;
        } else if ((j != chosen) && !select->hidden) {
            gather_one(step, j);
        } else {
            /* its evidence stands still */
        }
    }
}

void davar_select_choose(const select_step_t *step, davar_select_verdict_t *verdict)
{
    davar_select_t *const select = step->select;
    const bool stays = davar_select_has(step->usable, select->chosen);
    uint32_t best = select->chosen;
    float most = stays ? select->threshold : 0.0F;
    for (uint32_t j = 0U; j < select->config->gyros; j++) {
        const float merit = stays ? select->gyro[j].evidence : verdict->weight[j];
        if (davar_select_has(step->usable, j) && (merit > most)) {
            most = merit;
            best = j;
        }
    }
    verdict->switched = (best != select->chosen);
    if (verdict->switched) {
        select->gyro[select->chosen].spread = select->gyro[best].spread; /* of the same pair */
        select->chosen = (uint8_t)best;
        for (uint32_t j = 0U; j < select->config->gyros; j++) {
            select->gyro[j].evidence = 0.0F;
        }
    }
    verdict->chosen = select->chosen;
}
