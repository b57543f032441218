/* davar on a bare board - a job file of the host (davar_job.h) as the board's source of samples. */
#ifndef JOB_FILE_H
#define JOB_FILE_H

#include "davar/davar.h"
#include "davar_job.h"

#ifdef DAVAR_SMALL /* 16 kB of RAM */
#define JOB_FILE_CHANNELS 3U
#define JOB_FILE_POOL_WORDS 1240U
#define JOB_FILE_BUFFER_WORDS 64U
#else
#define JOB_FILE_CHANNELS 8U
#define JOB_FILE_POOL_WORDS 200000U
#define JOB_FILE_BUFFER_WORDS 1024U
#endif

/* Exit status of an image. */
enum { JOB_DONE = 0, JOB_NO_FILE = 3, JOB_UNKNOWN = 4, JOB_NO_MEMORY = 5, JOB_REFUSED = 6 };

/* Belongs to the caller. `job` is valid after a good job_file_open; the rest is private. */
typedef struct {
    davar_job_t job;
    int handle;
    davar_plan_t plan; /* of the fit, for all channels */
    davar_port_samples_t samples[JOB_FILE_CHANNELS];
    uint64_t buffer[JOB_FILE_BUFFER_WORDS]; /* samples of all channels */
    uint64_t pool[JOB_FILE_POOL_WORDS];     /* memory of all instances */
} job_file_t;

/* Opens a job and starts an instance per channel; there must be room for JOB_FILE_CHANNELS, or for
 * as many as the job is known to have. Returns JOB_DONE, or the status to exit with. */
int job_file_open(job_file_t *file, const char *path, davar_t *instances);

/* davar_port_t's read with a job_file_t for context: the next block, at most JOB_FILE_BUFFER_WORDS
 * of samples. */
davar_port_read_t job_file_read(void *context, davar_port_block_t *block);

#endif
