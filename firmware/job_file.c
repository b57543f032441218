/* davar on a bare board - a job file of the host. */
#include "job_file.h"

#include "board.h"

static size_t sample_bytes(const job_file_t *file)
{
    return (file->job.number == DAVAR_PORT_Q15) ? sizeof(int16_t) : sizeof(int32_t);
}

/* Moves the samples of each channel to its place after those of the previous channel. */
static void spread(job_file_t *file, uint32_t count)
{
    const size_t bytes = sample_bytes(file);
    for (uint32_t c = 0U; c < file->job.channels; c++) {
        file->samples[c].q15 =
            (const int16_t *)(const void *)((const char *)file->buffer + (c * count * bytes));
    }
}

davar_port_read_t job_file_read(void *context, davar_port_block_t *block)
{
    job_file_t *const file = context;
    uint32_t head[2] = {0U, 0U};
    if (board_read(file->handle, head, sizeof head) != sizeof head) {
        return DAVAR_PORT_READ_FAULT;
    }
    const uint32_t count = head[1];
    if (count == 0U) {
        return DAVAR_PORT_READ_END;
    }
    const size_t bytes = (size_t)count * file->job.channels * sample_bytes(file);
    if ((bytes > sizeof file->buffer) || (board_read(file->handle, file->buffer, bytes) != bytes)) {
        return DAVAR_PORT_READ_FAULT;
    }
    spread(file, count);
    *block = (davar_port_block_t){.samples = file->samples, .count = count, .missing = head[0]};
    return DAVAR_PORT_READ_BLOCK;
}

static davar_status_t init(const job_file_t *file, davar_t *davar, void *memory, size_t bytes)
{
    switch (file->job.number) {
    case DAVAR_PORT_Q15:
        return davar_init_q15(davar, &file->job.config, memory, bytes);
    case DAVAR_PORT_Q31:
        return davar_init_q31(davar, &file->job.config, memory, bytes);
    case DAVAR_PORT_F32:
    default:
        return davar_init_f32(davar, &file->job.config, memory, bytes);
    }
}

static size_t words_of(size_t bytes)
{
    return (bytes + 7U) / sizeof(uint64_t);
}

#define CASCADE_WORDS words_of(sizeof(davar_cascade_t))

static size_t instance_words(const job_file_t *file)
{
    const davar_config_t *const config = &file->job.config;
    const size_t bytes = (file->job.number == DAVAR_PORT_Q15)   ? davar_memory_size_q15(config)
                         : (file->job.number == DAVAR_PORT_Q31) ? davar_memory_size_q31(config)
                                                                : davar_memory_size_f32(config);
    return words_of(bytes);
}

/* Zero without a cascade. */
static size_t stages_words(const job_file_t *file)
{
    return words_of(davar_curve_bytes(&file->job.curve, file->job.number));
}

davar_cascade_t *job_file_cascade(job_file_t *file, uint32_t channel)
{
    uint64_t *const words = &file->pool[(channel * file->channel_words) + file->instance_words];
    return (stages_words(file) > 0U) ? (davar_cascade_t *)(void *)words : NULL;
}

static bool start(job_file_t *file, uint32_t channel, davar_t *davar)
{
    uint64_t *const memory = &file->pool[channel * file->channel_words];
    davar_cascade_t *const cascade = job_file_cascade(file, channel);
    if (init(file, davar, memory, file->instance_words * sizeof *memory) != DAVAR_OK) {
        return false;
    }
    return (cascade == NULL) ||
           (davar_curve_start(&file->job.curve, file->job.number, cascade,
                              memory + file->instance_words + CASCADE_WORDS,
                              stages_words(file) * sizeof *memory) == DAVAR_CASCADE_OK);
}

int job_file_open(job_file_t *file, const char *path, davar_t *instances)
{
    _Static_assert(DAVAR_JOB_WORDS <= JOB_FILE_POOL_WORDS, "the pool holds the header of a job");
    uint64_t *const words = file->pool; /* no instance has it yet */
    const size_t bytes = DAVAR_JOB_WORDS * sizeof *words;
    file->handle = board_open(path, false);
    if ((file->handle < 0) || (board_read(file->handle, words, bytes) != bytes)) {
        return JOB_NO_FILE;
    }
    davar_job_t *const job = &file->job;
    if (!davar_job_decode(job, words) || (job->channels == 0U) ||
        (job->channels > JOB_FILE_CHANNELS)) {
        return JOB_UNKNOWN;
    }
    file->instance_words = instance_words(file);
    file->channel_words = file->instance_words;
    if (stages_words(file) > 0U) {
        file->channel_words += CASCADE_WORDS + stages_words(file);
    }
    if ((file->channel_words * job->channels) > JOB_FILE_POOL_WORDS) {
        return JOB_NO_MEMORY;
    }
    for (uint32_t c = 0U; c < job->channels; c++) {
        if (!start(file, c, &instances[c])) {
            return JOB_REFUSED;
        }
    }
    davar_curve_plan(&job->curve, &file->plan, job->declared ? &job->filter : NULL);
    return JOB_DONE;
}
