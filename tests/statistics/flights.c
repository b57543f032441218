/* Which of several gyros to trust: wrong switches, delays, fused noise and faults over simulated
 * flights, beside simple rules. On seeds that chose no constant. A trial is an hour of each flight,
 * or as many as a row states. */
#include "flight.h"
#include "statistics.h"

#define BLOCK 10U
#define MINUTES_20 12000U /* blocks */
#define AHEAD 20U         /* blocks; a switch that a change overtook within 2 s is not wrong */

static davar_select_config_t flown;
static davar_select_t selection;
static davar_select_gyro_t gyro[DAVAR_SELECT_GYROS];
static davar_select_pair_t pair[DAVAR_SELECT_PAIRS(DAVAR_SELECT_GYROS)];
static davar_select_verdict_t verdict;
static flight_t flight;
static float square[DAVAR_SELECT_GYROS]; /* of the newest block */
static uint64_t next_seed;

static void choose(uint8_t gyros, uint8_t axes, float errors_per_1000_h)
{
    flown = (davar_select_config_t){
        .gyros = gyros, .axes = axes, .block = BLOCK, .rate_hz = 100.0F, DAVAR_SELECT_DEFAULTS};
    if (errors_per_1000_h > 0.0F) {
        flown.errors_per_1000_h = errors_per_1000_h;
    }
}

static void take_off(flight_noise_t kind)
{
    require(davar_select_init(&selection, &flown, gyro, pair) == DAVAR_SELECT_OK, "flights: init");
    flight_start(&flight, next_seed, &flown, kind);
    next_seed++;
}

/* One block. Of `stuck` and `absent` the bits are gyros. */
static void fly(uint32_t stuck, uint32_t absent)
{
    static float rates[DAVAR_SELECT_GYROS * DAVAR_SELECT_AXES];
    float before[DAVAR_SELECT_GYROS * DAVAR_SELECT_AXES];
    for (uint32_t k = 0U; k < flown.block; k++) {
        memcpy(before, rates, sizeof before);
        flight_sample(&flight, rates);
        for (uint32_t i = 0U; i < (uint32_t)flown.gyros * flown.axes; i++) {
            rates[i] = (((stuck >> (i / flown.axes)) & 1U) != 0U) ? before[i] : rates[i];
            rates[i] = (((absent >> (i / flown.axes)) & 1U) != 0U) ? NAN : rates[i];
        }
        const bool full = davar_select_add(&selection, rates);
        require(full == (k + 1U == flown.block), "flights: a block");
    }
    for (uint32_t i = 0U; i < flown.gyros; i++) {
        square[i] = gyro[i].square[0] + gyro[i].square[1] + gyro[i].square[2];
    }
    davar_select_update(&selection, &verdict);
}

/* ---- between gyros of equal noise ---- */

typedef struct {
    uint8_t gyros; /* 0: as the movement states */
    uint8_t axes;
    float stated;    /* wrong switches per 1000 h */
    float tolerance; /* of time, s */
    double hours;    /* of a trial, which is a third of an hour */
} crew_t;

/* A high stated rate makes short flights a strict test. */
static const crew_t equal[] = {{2U, 1U, 10000.0F, 0.0005F, 2.0},
                               {4U, 1U, 10000.0F, 0.0005F, 1.0},
                               {3U, 3U, 10000.0F, 0.0005F, 1.0},
                               {2U, 1U, 100.0F, 0.0005F, 20.0}};

/* At the default rate: a single switch fails. Mismatch of scale and time, within the tolerances,
 * makes gyros of equal noise look different. */
static const crew_t rides[] = {{0U, 1U, 1.0F, 0.0005F, 1.0},
                               {0U, 3U, 1.0F, 0.0005F, 1.0},
                               {0U, 3U, 1.0F, 0.0012F, 1.0},
                               {2U, 3U, 1.0F, 0.0012F, 1.0}};

typedef struct {
    const char *name;
    flight_noise_t kind;
    uint8_t gyros;
    double shake;
    double vibration;
    double tone; /* at 23 Hz */
} ride_t;

static const ride_t kinds[] = {
    {"Gauss", NOISE_GAUSS, 0U, 0.0, 0.0, 0.0},
    {"Laplace", NOISE_LAPLACE, 0U, 0.0, 0.0, 0.0},
    {"Student t5", NOISE_STUDENT_5, 0U, 0.0, 0.0, 0.0},
    {"AR(1) 0.7", NOISE_MARKOV, 0U, 0.0, 0.0, 0.0},
    {"steps AR(1) 0.7", NOISE_MARKOV_STEP, 0U, 0.0, 0.0, 0.0},
    {"each sample three times", NOISE_HELD, 0U, 0.0, 0.0, 0.0},
};

static const ride_t movements[] = {
    {"shake 150", NOISE_GAUSS, 3U, 150.0, 0.0, 0.0},
    {"shake 600", NOISE_GAUSS, 4U, 600.0, 0.0, 0.0},
    {"shake 1500", NOISE_GAUSS, 3U, 1500.0, 0.0, 0.0},
    {"vibration", NOISE_GAUSS, 4U, 0.0, 5.0, 0.0},
    {"tone 0.3", NOISE_GAUSS, 3U, 0.0, 0.0, 0.3},
    {"tone 1", NOISE_GAUSS, 4U, 0.0, 0.0, 1.0},
    {"tone 5", NOISE_GAUSS, 3U, 0.0, 0.0, 5.0},
};

typedef struct {
    uint32_t switches;
    uint32_t alarms;
    uint32_t hidden;
    double excess; /* of the fused noise, sum over blocks */
} counted_t;

static void ride_once(const ride_t *ride, counted_t *counted)
{
    bool alarm = false;
    take_off(ride->kind);
    flight.tone_hz = 23.0;
    for (uint32_t t = 0U; t < MINUTES_20; t++) {
        const bool before = alarm;
        double fused = 0.0;
        if (t == 600U) {
            flight.shake = ride->shake;
            flight.vibration = ride->vibration;
            flight.tone = ride->tone;
        }
        fly(0U, 0U);
        counted->switches += verdict.switched ? 1U : 0U;
        counted->hidden += verdict.hidden ? 1U : 0U;
        alarm = verdict.disagree;
        for (uint32_t i = 0U; i < flown.gyros; i++) {
            fused += (double)verdict.weight[i] * (double)verdict.weight[i] * flown.gyros;
            alarm = alarm || (verdict.fault[i] != 0U);
        }
        counted->excess += (fused > 0.0) ? (sqrt(fused) - 1.0) : 0.0;
        counted->alarms += (alarm && !before) ? 1U : 0U;
    }
}

/* Switches and alarms over the stated ones. Where means wander, alarms are right. */
static void fly_rides(const crew_t *crew, const ride_t *ride, unsigned trials, const char *holds)
{
    const uint32_t count = (uint32_t)lround(trials * crew->hours);
    const double stated = 0.001 * (double)crew->stated * count / 3.0;
    const double percent = 100.0 / (12000.0 * count);
    counted_t counted = {0U, 0U, 0U, 0.0};
    choose((crew->gyros > 0U) ? crew->gyros : ride->gyros, crew->axes, crew->stated);
    flown.time_tolerance_s = crew->tolerance;
    for (uint32_t f = 0U; f < count; f++) {
        ride_once(ride, &counted);
    }
    value("hours", count / 3.0, 0.0);
    value("stated", (double)crew->stated, 0.0);
    value("switches", counted.switches / stated, 0.0);
    value("alarms", counted.alarms / stated, 0.0);
    value("fused", percent * counted.excess, 0.0);
    value("hidden", percent * counted.hidden, 0.0);
    label("%s, %u gyros, %u axes", ride->name, flown.gyros, flown.axes);
    report(holds);
}

static void run_equal(const void *crew, unsigned trials, uint64_t seed)
{
    for (size_t i = 0U; i < COUNT_OF(kinds); i++) {
        next_seed = seed;
        fly_rides(crew, &kinds[i], trials,
                  (kinds[i].kind == NOISE_MARKOV_STEP) ? "switches :1" : "switches :1, alarms :1");
    }
}

static void run_rides(const void *crew, unsigned trials, uint64_t seed)
{
    for (size_t i = 0U; i < COUNT_OF(movements); i++) {
        next_seed = seed;
        fly_rides(crew, &movements[i], trials, "switches :0, alarms :0, fused :2");
    }
}

const experiment_t flights_equal_experiment = {ROWS(equal), run_equal};
const experiment_t flights_rides_experiment = {ROWS(rides), run_rides};

/* ---- the time until a chosen gyro whose noise grows is left ---- */

typedef struct {
    const char *name;
    const char *holds; /* mean seconds */
    uint8_t gyros;
    uint8_t axes;
    double ratio;
    double shake;
    unsigned part; /* of the trials */
} louder_t;

static const louder_t louder[] = {
    {"x1.25", "mean 11:20", 3U, 1U, 1.25, 0.0, 4U},
    {"x1.5", "mean 3.3:4", 3U, 1U, 1.5, 0.0, 1U},
    {"x1.5", "mean 3.5:4.3", 2U, 1U, 1.5, 0.0, 1U},
    {"x1.5", "mean 3.2:4", 4U, 1U, 1.5, 0.0, 2U},
    {"x1.5", "mean 1.2:1.7", 3U, 3U, 1.5, 0.0, 2U},
    {"x2", "mean 1.7:2.2", 3U, 1U, 2.0, 0.0, 2U},
    {"x5", "mean 0.7:1.1", 3U, 3U, 5.0, 0.0, 2U},
    {"x2, in motion", "mean 3:5", 3U, 1U, 2.0, 150.0, 4U},
};

static void run_delays(const void *of, unsigned trials, uint64_t seed)
{
    const louder_t *const row = of;
    const uint32_t count = trials / row->part;
    double sum = 0.0;
    next_seed = seed;
    choose(row->gyros, row->axes, 1.0F);
    for (uint32_t f = 0U; f < count; f++) {
        uint32_t blocks = 0U;
        take_off(NOISE_GAUSS);
        flight.shake = row->shake;
        for (uint32_t t = 0U; t < 600U; t++) {
            fly(0U, 0U);
        }
        const uint32_t loud = verdict.chosen;
        flight.own[loud] = row->ratio;
        while ((verdict.chosen == loud) && (blocks < 1200U)) {
            fly(0U, 0U);
            blocks++;
        }
        sum += 0.1 * blocks;
    }
    value("mean", sum / count, 0.0);
    label("%s, %u gyros, %u axes", row->name, row->gyros, row->axes);
    report(row->holds);
}

const experiment_t flights_delays_experiment = {ROWS(louder), run_delays};

/* ---- fused noise, and simple rules ---- */

typedef enum { ALIKE, STEPS, REGIMES, CONSTANT } scene_t;

typedef struct {
    const char *name;
    const char *holds;
    uint8_t gyros;
    uint8_t axes;
    scene_t scene;
    double ratio;
    double motion; /* part of the time */
} scene_row_t;

/* Of one gyro in the noise of 1 to 5, equal weights have far more noise. */
static const scene_row_t scenes[] = {
    {"equal", "fused :0.5, wrong :1", 3U, 1U, ALIKE, 1.0, 0.0},
    {"steps x1.5", "fused :2, equal 4:11, wrong :1", 3U, 1U, STEPS, 1.5, 0.0},
    {"regimes", "fused :2, equal 4:14, wrong :1", 3U, 1U, REGIMES, 1.0, 0.0},
    {"regimes, half in motion", "fused :2, wrong :1", 3U, 1U, REGIMES, 1.0, 0.5},
    {"steps x2, always in motion", "fused :2, wrong :1", 3U, 1U, STEPS, 2.0, 1.0},
    {"regimes, half in motion", "fused :2, wrong :1", 3U, 3U, REGIMES, 1.0, 0.5},
    {"steps x2, always in motion", "fused :2, wrong :1", 3U, 3U, STEPS, 2.0, 1.0},
    {"equal", "fused :0.5, wrong :1", 4U, 1U, ALIKE, 1.0, 0.0},
    {"steps x1.5", "fused :2, wrong :1", 4U, 1U, STEPS, 1.5, 0.0},
    {"regimes", "fused :2, wrong :1", 4U, 1U, REGIMES, 1.0, 0.0},
    {"regimes, half in motion", "fused :2, wrong :1", 4U, 1U, REGIMES, 1.0, 0.5},
    {"steps x2, always in motion", "fused :2, wrong :1", 4U, 1U, STEPS, 2.0, 1.0},
    {"regimes, half in motion", "fused :2, wrong :1", 4U, 3U, REGIMES, 1.0, 0.5},
    {"steps x2, always in motion", "fused :2, wrong :1", 4U, 3U, STEPS, 2.0, 1.0},
    {"regimes, half in motion", "fused :8, wrong :1", 2U, 1U, REGIMES, 1.0, 0.5},
    {"constant 1:5", "fused :0.5, equal 135:175", 2U, 1U, CONSTANT, 5.0, 0.0},
    {"constant 1:5:5", "fused :0.5, equal 135:175", 3U, 1U, CONSTANT, 5.0, 0.0},
};

typedef struct {
    double equal; /* fused own noise over the optimum, sums over blocks */
    double fused;
    double single; /* of the chosen gyro over the quietest one */
    double least;
    double average;
    uint32_t switches;
    uint32_t least_switches;
    uint32_t average_switches;
    uint32_t wrong;
    uint32_t blocks;
} tally_t;

typedef struct {
    float totals[BLOCK][DAVAR_SELECT_GYROS];
    double average[DAVAR_SELECT_GYROS]; /* of the noise, over 2 s */
    double past[AHEAD][DAVAR_SELECT_GYROS];
    uint32_t least;
    uint32_t smooth;
} rules_t;

/* The gyro with the least variance of 1 s; the gyro that an average of 2 s shows 10 % quieter. */
static void apply_rules(rules_t *rules, uint32_t t, tally_t *tally)
{
    uint32_t least = rules->least;
    uint32_t smooth = rules->smooth;
    double totals[DAVAR_SELECT_GYROS] = {0.0};
    for (uint32_t i = 0U; i < flown.gyros; i++) {
        rules->totals[t % BLOCK][i] = square[i];
        const double noise = sqrt((double)square[i]);
        rules->average[i] += (noise - rules->average[i]) * ((t == 0U) ? 1.0 : 0.05);
        for (uint32_t k = 0U; k < BLOCK; k++) {
            totals[i] += (double)rules->totals[k][i];
        }
    }
    for (uint32_t i = 0U; i < flown.gyros; i++) {
        least = (totals[i] < totals[least]) ? i : least;
        smooth = ((rules->average[i] < 0.9 * rules->average[rules->smooth]) &&
                  (rules->average[i] < rules->average[smooth]))
                     ? i
                     : smooth;
    }
    tally->least_switches += (least != rules->least) ? 1U : 0U;
    tally->average_switches += (smooth != rules->smooth) ? 1U : 0U;
    rules->least = least;
    rules->smooth = smooth;
}

static double excess_of(uint32_t i, double best)
{
    const double common = flight.vibration * flight.vibration;
    return sqrt(((flight.own[i] * flight.own[i]) + common) / (best + common)) - 1.0;
}

static void rate_block(const rules_t *rules, tally_t *tally)
{
    double inverse = 0.0;
    double equal_weights = 0.0;
    double fused = 0.0;
    double best = 1e9;
    const double n = flown.gyros;
    for (uint32_t i = 0U; i < flown.gyros; i++) {
        const double own = flight.own[i] * flight.own[i];
        inverse += 1.0 / own;
        equal_weights += own / (n * n);
        fused += (double)verdict.weight[i] * (double)verdict.weight[i] * own;
        best = (own < best) ? own : best;
    }
    tally->equal += sqrt(equal_weights * inverse) - 1.0;
    tally->fused += sqrt(fused * inverse) - 1.0;
    tally->single += excess_of(verdict.chosen, best);
    tally->least += excess_of(rules->least, best);
    tally->average += excess_of(rules->smooth, best);
    tally->blocks++;
}

/* Was the new gyro not quieter than the old one at any time in the last 2 s? */
static bool is_wrong(const rules_t *rules, uint32_t before)
{
    bool wrong = true;
    for (uint32_t k = 0U; k < AHEAD; k++) {
        wrong = wrong && (rules->past[k][verdict.chosen] >= rules->past[k][before]);
    }
    return wrong;
}

static double wait_of(double mean_s)
{
    return -mean_s * log(random_uniform(&flight.random));
}

static uint32_t pick(uint32_t count)
{
    return (uint32_t)(random_uniform(&flight.random) * count);
}

/* Changes of the truth: a gyro at a time that is louder; or vibration and noise of all. */
static void change(scene_t scene, double ratio, double motion, double now, double *due)
{
    static const double levels[] = {1.0, 1.1, 1.25, 1.5, 2.0};
    static const double vibrations[] = {0.0, 1.0, 2.0, 5.0};
    static uint32_t loud;
    if ((scene == STEPS) && (now >= due[0])) {
        flight.own[loud % flown.gyros] = 1.0;
        loud = (loud + 1U + pick(flown.gyros - 1U)) % flown.gyros;
        flight.own[loud] = ratio;
        due[0] = now + 12.0 + wait_of(20.0);
    }
    for (uint32_t i = 0U; (scene == CONSTANT) && (i < flown.gyros); i++) {
        flight.own[i] = (i == 0U) ? 1.0 : ratio;
    }
    for (uint32_t i = 0U; (scene == REGIMES) && (i < flown.gyros); i++) {
        if (now >= due[i]) {
            flight.own[i] = levels[pick(5U)];
            due[i] = now + wait_of(30.0);
        }
    }
    if ((scene == REGIMES) && (now >= due[4])) {
        flight.vibration = vibrations[pick(4U)];
        due[4] = now + wait_of(10.0);
    }
    if ((scene != CONSTANT) && (now >= due[5])) {
        flight.shake = (random_uniform(&flight.random) < motion) ? 150.0 : 3.0;
        due[5] = now + wait_of(10.0);
    }
}

static void run_fused(const void *of, unsigned trials, uint64_t seed)
{
    const scene_row_t *const row = of;
    tally_t tally = {0};
    next_seed = seed;
    choose(row->gyros, row->axes, 1.0F);
    for (unsigned f = 0U; f < trials; f++) {
        rules_t rules = {.least = 0U};
        double due[6] = {5.0, 0.0, 0.0, 0.0, 0.0, 0.0};
        take_off(NOISE_GAUSS);
        for (uint32_t t = 0U; t < MINUTES_20; t++) {
            const uint32_t before = selection.chosen;
            change(row->scene, row->ratio, row->motion, 0.1 * t, due);
            memcpy(rules.past[t % AHEAD], flight.own, sizeof flight.own);
            fly(0U, 0U);
            apply_rules(&rules, t, &tally);
            rate_block(&rules, &tally);
            tally.switches += verdict.switched ? 1U : 0U;
            tally.wrong += (verdict.switched && is_wrong(&rules, before)) ? 1U : 0U;
        }
    }
    const double hours = tally.blocks / 36000.0;
    const double percent = 100.0 / tally.blocks;
    value("fused", percent * tally.fused, 0.0);
    value("equal", percent * tally.equal, 0.0);
    value("select", percent * tally.single, 0.0);
    value("switches", tally.switches / hours, 0.0);
    value("wrong", tally.wrong, 0.0);
    value("average", percent * tally.average, 0.0);
    value("switches", tally.average_switches / hours, 0.0);
    value("least", percent * tally.least, 0.0);
    value("switches", tally.least_switches / hours, 0.0);
    label("%s, %u gyros, %u axes", row->name, row->gyros, row->axes);
    report(row->holds);
}

const experiment_t flights_fused_experiment = {ROWS(scenes), run_fused};

/* ---- faults ---- */

typedef enum { STUCK, DROPOUT, MEAN, NOISE } fault_t;

typedef struct {
    const char *name;
    const char *holds; /* of found, percent; that of named for three and four gyros */
    fault_t fault;
    double size;
    double motion;
} fault_row_t;

#define NO_OTHER "other :0, chosen :0, false :0"

/* Noise x3 is never found, because the past has a ratio of 2; but no other gyro is named. */
static const fault_row_t fault_rows[] = {
    {"stuck", "named 100:, delay :0.5, " NO_OTHER, STUCK, 0.0, 0.3},
    {"dropout", "named 100:, delay :0.5, " NO_OTHER, DROPOUT, 0.0, 0.3},
    {"mean 5", "found 95:, " NO_OTHER, MEAN, 5.0, 0.8},
    {"mean 1", "found 95:, " NO_OTHER, MEAN, 1.0, 0.2},
    {"mean 1", "found 93:, " NO_OTHER, MEAN, 1.0, 0.8},
    {"mean 0.3", "found 95:, " NO_OTHER, MEAN, 0.3, 0.2},
    {"noise x3", NO_OTHER, NOISE, 3.0, 0.3},
    {"noise x10", NO_OTHER, NOISE, 10.0, 0.3},
};

typedef struct {
    double found;
    double named;  /* the right gyro, and no other */
    double other;  /* another gyro was named */
    double chosen; /* the selection stayed on the faulty gyro */
    double false_alarms;
    double delay_s;
} found_t;

static uint32_t named_gyros(uint8_t bits)
{
    uint32_t named = 0U;
    for (uint32_t i = 0U; i < flown.gyros; i++) {
        named |= ((verdict.fault[i] & bits) != 0U) ? (1U << i) : 0U;
    }
    return named;
}

/* One flight, in which the gyro of bit `bad` has a fault from block `start` on. */
static void fly_with_fault(const fault_row_t *row, found_t *all)
{
    static const uint8_t bits[] = {DAVAR_SELECT_STUCK, DAVAR_SELECT_ABSENT, DAVAR_SELECT_MEAN,
                                   DAVAR_SELECT_NOISE};
    double due[6] = {0.0};
    take_off(NOISE_GAUSS);
    const uint32_t which = pick(flown.gyros);
    const uint32_t bad = 1U << which;
    const uint32_t start = 2000U + pick(1000U);
    uint32_t found = 0U;
    for (uint32_t t = 0U; (t < start + 600U) && (found == 0U); t++) {
        const bool on = (t >= start);
        change(REGIMES, 1.0, row->motion, 0.1 * t, due);
        for (uint32_t i = 0U; on && (i < flown.gyros) && (row->fault == NOISE); i++) {
            flight.own[i] = (i == which) ? row->size : 1.0;
        }
        flight.bias[which][0] += ((t == start) && (row->fault == MEAN)) ? row->size : 0.0;
        fly((on && (row->fault == STUCK)) ? bad : 0U, (on && (row->fault == DROPOUT)) ? bad : 0U);
        const uint32_t named = named_gyros(bits[row->fault]);
        const bool seen = (named != 0U) || ((row->fault == MEAN) && verdict.disagree);
        const bool enough = (row->fault == MEAN) && (flown.gyros > 2U) ? (named != 0U) : seen;
        all->false_alarms += (seen && !on) ? 1.0 : 0.0;
        if (enough && on) {
            const bool stays = (row->fault != NOISE) && (flown.gyros > 2U);
            found = t + 1U - start;
            all->named += (named == bad) ? 1.0 : 0.0;
            all->other += ((named & ~bad) != 0U) ? 1.0 : 0.0;
            all->chosen += (stays && (verdict.chosen == which)) ? 1.0 : 0.0;
        }
    }
    all->found += (found > 0U) ? 1.0 : 0.0;
    all->delay_s += 0.1 * found;
}

static void run_faults(const void *of, unsigned trials, uint64_t seed)
{
    const fault_row_t *const row = of;
    for (uint8_t gyros = 2U; gyros <= 4U; gyros++) {
        found_t all = {.found = 0.0};
        next_seed = seed;
        choose(gyros, 1U, 1.0F);
        for (unsigned f = 0U; f < trials; f++) {
            fly_with_fault(row, &all);
        }
        share("found", all.found, trials);
        value("delay", all.delay_s / all.found, 0.0);
        value("named", 100.0 * all.named / trials, 0.0);
        value("other", all.other, 0.0);
        value("chosen", all.chosen, 0.0);
        value("false", all.false_alarms, 0.0);
        label("%s, motion %.1f, %u gyros", row->name, row->motion, gyros);
        report(row->holds);
        if ((row->fault == NOISE) && (row->size > 5.0) && (gyros > 2U)) {
            value("named", 100.0 * all.named / trials, 0.0);
            report("named 100:");
        }
    }
}

const experiment_t flights_faults_experiment = {ROWS(fault_rows), run_faults};
