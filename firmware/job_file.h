/* davar on a bare board - a job file of the host (davar_job.h) as the board's source of samples. */
#ifndef JOB_FILE_H
#define JOB_FILE_H

#include "davar/davar.h"
#include "davar/fit.h"
#include "davar_job.h"

#ifdef DAVAR_SMALL     /* 16 kB of RAM */
#if DAVAR_TAUS_MAX > 8 /* for a cascade: plan, results and stack are larger */
#define JOB_FILE_CHANNELS 1U
#define JOB_FILE_POOL_WORDS 520U
#else
#define JOB_FILE_CHANNELS 3U
#define JOB_FILE_POOL_WORDS 1130U
#endif
#define JOB_FILE_BUFFER_WORDS 64U
#else
#define JOB_FILE_CHANNELS 8U
#define JOB_FILE_POOL_WORDS 200000U
#define JOB_FILE_BUFFER_WORDS 1024U
#endif

/* Exit status of an image. */
enum { JOB_DONE = 0, JOB_NO_FILE = 3, JOB_UNKNOWN = 4, JOB_NO_MEMORY = 5, JOB_REFUSED = 6 };

/* Belongs to the caller. `job` is valid after job_file_open returned JOB_DONE; the rest is
 * private. */
typedef struct {
    davar_job_t job;
    int handle;
    davar_plan_t plan; /* of the fit, for all channels */
    davar_port_samples_t samples[JOB_FILE_CHANNELS];
    uint64_t buffer[JOB_FILE_BUFFER_WORDS]; /* samples of all channels */
    /* of each channel: memory of its instance, then its cascade and the memory of that */
    uint64_t pool[JOB_FILE_POOL_WORDS];
    size_t instance_words;
    size_t channel_words;
} job_file_t;

/* Opens a job and starts one instance per channel. `instances` must have room for JOB_FILE_CHANNELS
 * elements, or for the channels of a known job. Returns JOB_DONE, or the exit status. */
int job_file_open(job_file_t *file, const char *path, davar_t *instances);

/* The cascade of a channel of an open job; null: the job has none. */
davar_cascade_t *job_file_cascade(job_file_t *file, uint32_t channel);

/* The read function of davar_port_t; its context is a job_file_t. Returns the next block, at most
 * JOB_FILE_BUFFER_WORDS of samples. */
davar_port_read_t job_file_read(void *context, davar_port_block_t *block);

#endif
