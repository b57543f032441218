/* davar tests - the part of zlib that davar-sim uses, for a machine without zlib in Debian: it
 * cannot unpack anything. */
#ifndef ZLIB_H
#define ZLIB_H

#define Z_NO_FLUSH 0
#define Z_OK 0
#define Z_STREAM_END 1
#define Z_DATA_ERROR (-3)
#define Z_MEM_ERROR (-4)
#define Z_BUF_ERROR (-5)
#define z_const const

typedef unsigned char Bytef;
typedef unsigned uInt;

typedef struct {
    const Bytef *next_in;
    Bytef *next_out;
    uInt avail_in;
    uInt avail_out;
    const char *msg;
} z_stream;

static inline int inflateInit2(z_stream *stream, int bits)
{
    (void)stream;
    (void)bits;
    return Z_OK;
}

static inline int inflateReset(z_stream *stream)
{
    (void)stream;
    return Z_OK;
}

static inline int inflate(z_stream *stream, int flush)
{
    (void)stream;
    (void)flush;
    return Z_DATA_ERROR;
}

static inline int inflateEnd(z_stream *stream)
{
    (void)stream;
    return Z_OK;
}

#endif
