/* rbt_writer.h: writes raybudget trace files (.rbt, version 1) from any renderer. C99 or C++11, no dependencies.
 *
 * In one source file:  #define RBT_WRITER_IMPLEMENTATION
 *                      #include "rbt_writer.h"
 * In all others:       #include "rbt_writer.h"
 *
 * A trace says what each ray visited; docs/trace-format.md has the format and the meaning of every step and header field.
 *
 *     rbt_writer writer;
 *     rbt_begin(&writer, "frame.rbt", &header, &tree);
 *     rbt_tile tile;
 *     rbt_tile_init(&tile, &writer);
 *     for (uint32_t i = 0; i < writer.tiles; i++) {
 *         rbt_tile_begin(&tile, i);
 *         for each set and ray that is cast, in any order:
 *             rbt_begin_ray(&tile, set, ray);
 *             rbt_step(&tile, RBT_NODE, id); ...       from inside the traversal loop
 *             rbt_end_ray(&tile, triangle or RBT_MISS);
 *         rbt_tile_end(&tile);
 *         rbt_write_tile(&writer, &tile);
 *     }
 *     rbt_tile_free(&tile);
 *     if (rbt_finish(&writer, 0) != RBT_OK) puts(writer.message);
 *
 * Errors: every function that can fail returns an rbt_status, and the object then has a sentence in `message`. The first error of a writer
 * stays, and that of a tile until the object begins another tile: later calls do nothing and return it again, and rbt_write_tile hands a tile's
 * error to the writer. So it is enough to look at what rbt_finish returns. Of rbt_header.more only a reader checks more than that it is UTF-8.
 *
 * Files: the trace is written to PATH.part, which gets its name in rbt_finish; an error or rbt_abandon removes it. C99 cannot create a file only
 * where there is none: a PATH.part that is there is overwritten, and of two processes that write the same PATH at once, each spoils the other's.
 *
 * Threads: a tile belongs to one thread at a time, and each thread may have tiles of its own. Between rbt_begin and rbt_finish all functions
 * of tiles only read the writer. rbt_write_tile changes it: call it from one thread at a time, with tiles in rising order.
 *
 * Size: the data are in zstd frames, but not compressed. With RBT_USE_ZSTD defined they are, by libzstd (link with -lzstd).
 */
#ifndef RBT_WRITER_H
#define RBT_WRITER_H

#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef enum rbt_status {
    RBT_OK = 0,
    RBT_MISUSE, /* what was asked does not fit the format */
    RBT_IO,     /* the file cannot be written */
    RBT_MEMORY  /* no memory is left */
} rbt_status;

/* What a step did, and what its id names. */
typedef enum rbt_op {
    RBT_POP = 0,       /* an entry of the stack was read; its depth, from 0 */
    RBT_RESTART = 1,   /* the traversal began again; from this node */
    RBT_UP = 2,        /* an ancestor was fetched again; node */
    RBT_NODE = 3,      /* a node was fetched and tested; node */
    RBT_PUSH = 4,      /* an entry of the stack was written; its depth, from 0 */
    RBT_INSTANCE = 5,  /* the ray went into an instance; instance */
    RBT_PRIMITIVE = 6, /* a triangle was tested; its place in the list of references */
    RBT_ANY_HIT = 7    /* an any-hit shader ran; the place in the list of references just tested */
} rbt_op;

/* A ray that hit nothing. */
#define RBT_MISS UINT32_MAX

/* A set of rays, at most one for each pixel. */
typedef struct rbt_ray_set {
    const char *kind; /* "primary", "shadow", "soft-shadow", "reflection", ... */
    uint32_t sample;  /* of its pixel, from 0; 0 for "primary" and "shadow" */
    uint32_t light;   /* to which its rays go, from 0; 0 for kinds that go to none, and for "shadow", whose n-th set goes to light n */
} rbt_ray_set;

/* What the trace is a trace of. Texts are UTF-8. Zero it before filling it in: what may be left out is then left out. */
typedef struct rbt_header {
    const char *generator;   /* the program that writes the file */
    const char *scene;       /* name of the scene */
    uint64_t scene_hash;     /* another number for other geometry, camera or lights */
    uint32_t width, height;  /* of the image in pixels, 1 to 32768; or both 0 ... */
    uint32_t rays;           /* ... and the number of rays of a list, 1 to 2^30 */
    const rbt_ray_set *ray_sets; /* in the order in which a pixel's shader casts them */
    size_t ray_set_count;
    const char *accel;       /* "bvh", "wide-bvh", "kd", "grid" or "two-level" */
    const char *traversal;   /* "stack", ... */
    const char *node_format; /* of wide nodes: "full-4", ...; NULL for others */
    const char *node_fetch;  /* "single" or "pair": what one RBT_NODE reads */
    const char *loop_structure; /* "while-while", "if-if" or "single-loop" */
    uint32_t stack_entries;  /* in memory, at most 65536; 0 without */
    uint32_t short_stack;    /* entries in registers, at most 65536; 0 without */
    uint32_t trail_bits;     /* 32 or 64 with a restart trail, else 0 */
    double sah_costs[2];     /* Ct and Ci of the build, for the report */
    uint32_t depth;          /* longest path from the root in edges, for the report */
    int closest_hit_shadows; /* not 0: rays to lights search the closest hit */
    int flat_normals;        /* not 0: shading reads no normals, but makes them from vertices */
    const char *more;        /* further keys, as in "\"remarks\":{\"left_out\":[],\"notes\":[\"...\"]}"; NULL for none */
} rbt_header;

typedef enum rbt_node_kind { RBT_INNER, RBT_LEAF, RBT_WIDE } rbt_node_kind;

/* A node's links. Make one with rbt_inner, rbt_leaf or rbt_wide. */
typedef struct rbt_node {
    rbt_node_kind kind;
    uint32_t first, count, leaves;
} rbt_node;

/* Children `left` and `left + 1`, behind their parent. */
static inline rbt_node rbt_inner(uint32_t left) {
    rbt_node node = {RBT_INNER, left, 2, 0};
    return node;
}
/* References `first` to `first + count - 1`. */
static inline rbt_node rbt_leaf(uint32_t first, uint32_t count) {
    rbt_node node = {RBT_LEAF, first, count, 0};
    return node;
}
/* A wide node: nodes `first` to `first + count - 1` are its children, and `leaves` leaves, which are no nodes; at most 8 together. */
static inline rbt_node rbt_wide(uint32_t first, uint32_t count, uint32_t leaves) {
    rbt_node node = {RBT_WIDE, first, count, leaves};
    return node;
}

/* A tree without its boxes. The writer copies what it needs of it. */
typedef struct rbt_tree {
    const rbt_node *nodes; /* the root first; of a grid its cells, all leaves */
    uint32_t node_count;
    const uint32_t *references; /* triangles in the order of the leaves; of a TLAS, instances */
    uint32_t reference_count;
    const uint32_t *seconds; /* with "compressed-8-pairs": the second places of pairs, rising; else NULL */
    uint32_t second_count;
    uint32_t triangles; /* how many there are to refer to */
} rbt_tree;

/* Growing bytes; private to the writer. */
typedef struct rbt_bytes {
    uint8_t *data;
    size_t count, room;
} rbt_bytes;

typedef struct rbt_writer {
    rbt_status status;
    char message[256]; /* what went wrong, empty if nothing did */
    uint32_t tiles;    /* how many the frame has */
    /* The rest is private. What tiles read does not change after rbt_begin. */
    uint32_t width, height, rays, triangles;
    uint64_t id_limits[8];
    size_t set_count;
    int32_t *sources; /* of each set, the set from whose hits its rays start, or -1 */
    uint8_t *is_table;
    char *path, *part;
    FILE *file;
    rbt_bytes offsets;
    uint64_t position, steps;
    uint32_t written;
} rbt_writer;

typedef struct rbt_tile {
    rbt_status status;
    char message[256];
    uint32_t index;
    uint32_t x, y, width, height; /* in pixels; of a list, its first ray, 0, its number of rays, 1 */
    /* The rest is private. */
    const rbt_writer *writer;
    struct rbt_ray *rays, *ray;
    uint32_t previous[4];
    uint64_t steps;
    rbt_bytes bytes, data, chunk;
    int ended;
} rbt_tile;

/* Opens PATH.part and writes the header and the tree. Also after an error rbt_finish or rbt_abandon frees the writer. */
rbt_status rbt_begin(rbt_writer *writer, const char *path, const rbt_header *header, const rbt_tree *tree);
/* The same for "two-level": a TLAS over instances, the mesh of each instance, and a BLAS for each mesh. Nodes of all trees are numbered together:
 * the TLAS from 0, and each BLAS from the next even number; references of BLASes together, one BLAS after the other. */
rbt_status rbt_begin_two_level(rbt_writer *writer, const char *path, const rbt_header *header, const rbt_tree *tlas,
                               const uint32_t *meshes, const rbt_tree *blases, uint32_t blas_count);

/* A tile object for this writer, to be used again and again; rbt_tile_free it before the writer begins another trace. */
void rbt_tile_init(rbt_tile *tile, const rbt_writer *writer);
/* Empties the object, also of its error, for tile `index`, counted in rows from the upper left, whose place is then in its fields. */
rbt_status rbt_tile_begin(rbt_tile *tile, uint32_t index);
/* Steps that follow belong to this ray: `set` of the header, `ray` = row in the tile * tile.width + column. Rays come in any order, each at
 * most once. A ray that is left out was not cast. Only these may not be left out: rays of sets that start from no hit ("primary"), and those of
 * "shadow" where the ray that they start from hit. */
rbt_status rbt_begin_ray(rbt_tile *tile, size_t set, uint32_t ray);
rbt_status rbt_step(rbt_tile *tile, rbt_op op, uint32_t id);
/* `triangle` in file order, or RBT_MISS. */
rbt_status rbt_end_ray(rbt_tile *tile, uint32_t triangle);
/* Encodes the tile: the work worth doing in parallel. */
rbt_status rbt_tile_end(rbt_tile *tile);
void rbt_tile_free(rbt_tile *tile);

/* Appends the tile of this writer, which can then begin another. */
rbt_status rbt_write_tile(rbt_writer *writer, const rbt_tile *tile);
/* Ends the file, gives it its name and frees the writer; `stalls` is the number of traversals cut off by a bound on their loop. */
rbt_status rbt_finish(rbt_writer *writer, uint64_t stalls);
/* Gives up: removes what was written and frees the writer; nothing after rbt_finish. */
void rbt_abandon(rbt_writer *writer);

#ifdef __cplusplus
}
#endif
#endif

#ifdef RBT_WRITER_IMPLEMENTATION
#include <errno.h>
#include <math.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
#ifdef RBT_USE_ZSTD
#include <zstd.h>
#endif

#ifdef __cplusplus
extern "C" {
#endif

#define RBT_MOST_IDS ((UINT32_C(1) << 29) - 1)
#define RBT_MOST_CHUNK_BYTES (UINT32_C(1) << 29)
#define RBT_MOST_TILE_STEPS (UINT32_C(1) << 26)
#define RBT_TILE_EDGE 32u
#define RBT_TILE_RAYS 1024u

/* Steps of one ray lie at offset in the tile's bytes. */
struct rbt_ray {
    size_t offset, length;
    uint32_t steps, hit; /* hit: 0 without, else 1 plus the triangle */
    int recorded;
};

/* ---- bytes: 0 where memory is out ---- */

static int rbt_reserve(rbt_bytes *bytes, size_t more) {
    size_t room = bytes->room < 256 ? 256 : bytes->room;
    uint8_t *data;
    if (bytes->room - bytes->count >= more) return 1;
    if (more > SIZE_MAX / 4 || bytes->count > SIZE_MAX / 4) return 0;
    while (room - bytes->count < more) room *= 2;
    data = (uint8_t *)realloc(bytes->data, room);
    if (!data) return 0;
    bytes->data = data;
    bytes->room = room;
    return 1;
}

static int rbt_put(rbt_bytes *bytes, const void *data, size_t count) {
    if (!rbt_reserve(bytes, count)) return 0;
    if (count) memcpy(bytes->data + bytes->count, data, count);
    bytes->count += count;
    return 1;
}

static int rbt_put_fixed(rbt_bytes *bytes, uint64_t value, int width) {
    uint8_t little[8];
    int i;
    for (i = 0; i < width; i++) little[i] = (uint8_t)(value >> 8 * i);
    return rbt_put(bytes, little, (size_t)width);
}

static int rbt_put_varint(rbt_bytes *bytes, uint64_t value) {
    if (!rbt_reserve(bytes, 10)) return 0;
    for (; value >= 0x80; value >>= 7) bytes->data[bytes->count++] = (uint8_t)(value | 0x80);
    bytes->data[bytes->count++] = (uint8_t)value;
    return 1;
}

/* Small whatever the sign: 2s from 0 on, -2s - 1 below. */
static uint64_t rbt_zigzag(int64_t s) { return s >= 0 ? (uint64_t)s * 2 : (uint64_t)(-(s + 1)) * 2 + 1; }

/* ---- XXH3-64 with a seed, for 9 bytes or more, as in xxHash 0.8 ---- */

static const uint8_t rbt_secret[192] = {
    0xb8, 0xfe, 0x6c, 0x39, 0x23, 0xa4, 0x4b, 0xbe, 0x7c, 0x01, 0x81, 0x2c, 0xf7, 0x21, 0xad, 0x1c, 0xde, 0xd4, 0x6d, 0xe9,
    0x83, 0x90, 0x97, 0xdb, 0x72, 0x40, 0xa4, 0xa4, 0xb7, 0xb3, 0x67, 0x1f, 0xcb, 0x79, 0xe6, 0x4e, 0xcc, 0xc0, 0xe5, 0x78,
    0x82, 0x5a, 0xd0, 0x7d, 0xcc, 0xff, 0x72, 0x21, 0xb8, 0x08, 0x46, 0x74, 0xf7, 0x43, 0x24, 0x8e, 0xe0, 0x35, 0x90, 0xe6,
    0x81, 0x3a, 0x26, 0x4c, 0x3c, 0x28, 0x52, 0xbb, 0x91, 0xc3, 0x00, 0xcb, 0x88, 0xd0, 0x65, 0x8b, 0x1b, 0x53, 0x2e, 0xa3,
    0x71, 0x64, 0x48, 0x97, 0xa2, 0x0d, 0xf9, 0x4e, 0x38, 0x19, 0xef, 0x46, 0xa9, 0xde, 0xac, 0xd8, 0xa8, 0xfa, 0x76, 0x3f,
    0xe3, 0x9c, 0x34, 0x3f, 0xf9, 0xdc, 0xbb, 0xc7, 0xc7, 0x0b, 0x4f, 0x1d, 0x8a, 0x51, 0xe0, 0x4b, 0xcd, 0xb4, 0x59, 0x31,
    0xc8, 0x9f, 0x7e, 0xc9, 0xd9, 0x78, 0x73, 0x64, 0xea, 0xc5, 0xac, 0x83, 0x34, 0xd3, 0xeb, 0xc3, 0xc5, 0x81, 0xa0, 0xff,
    0xfa, 0x13, 0x63, 0xeb, 0x17, 0x0d, 0xdd, 0x51, 0xb7, 0xf0, 0xda, 0x49, 0xd3, 0x16, 0x55, 0x26, 0x29, 0xd4, 0x68, 0x9e,
    0x2b, 0x16, 0xbe, 0x58, 0x7d, 0x47, 0xa1, 0xfc, 0x8f, 0xf8, 0xb8, 0xd1, 0x7a, 0xd0, 0x31, 0xce, 0x45, 0xcb, 0x3a, 0x8f,
    0x95, 0x16, 0x04, 0x28, 0xaf, 0xd7, 0xfb, 0xca, 0xbb, 0x4b, 0x40, 0x7e};

#define RBT_PRIME UINT64_C(0x9E3779B185EBCA87)

static uint64_t rbt_read64(const uint8_t *at) {
    uint64_t value = 0;
    int i;
    for (i = 7; i >= 0; i--) value = value << 8 | at[i];
    return value;
}

/* Both halves of the product of 128 bits, xored. */
static uint64_t rbt_fold(uint64_t a, uint64_t b) {
    uint64_t a0 = a & UINT32_MAX, a1 = a >> 32, b0 = b & UINT32_MAX, b1 = b >> 32;
    uint64_t cross = (a0 * b0 >> 32) + (a1 * b0 & UINT32_MAX) + a0 * b1;
    return (a * b) ^ (a1 * b1 + (a1 * b0 >> 32) + (cross >> 32));
}

static uint64_t rbt_avalanche(uint64_t h) {
    h = (h ^ h >> 37) * UINT64_C(0x165667919E3779F9);
    return h ^ h >> 32;
}

static uint64_t rbt_mix16(const uint8_t *data, size_t secret, uint64_t seed) {
    return rbt_fold(rbt_read64(data) ^ (rbt_read64(rbt_secret + secret) + seed),
                    rbt_read64(data + 8) ^ (rbt_read64(rbt_secret + secret + 8) - seed));
}

static void rbt_accumulate(uint64_t lanes[8], const uint8_t *data, const uint8_t *secret) {
    int i;
    for (i = 0; i < 8; i++) {
        uint64_t value = rbt_read64(data + 8 * i), key = value ^ rbt_read64(secret + 8 * i);
        lanes[i ^ 1] += value;
        lanes[i] += (key & UINT32_MAX) * (key >> 32);
    }
}

static uint64_t rbt_hash_long(const uint8_t *data, size_t count, uint64_t seed) {
    uint64_t lanes[8] = {UINT64_C(0xC2B2AE3D),         RBT_PRIME,
                         UINT64_C(0xC2B2AE3D27D4EB4F), UINT64_C(0x165667B19E3779F9),
                         UINT64_C(0x85EBCA77C2B2AE63), UINT64_C(0x85EBCA77),
                         UINT64_C(0x27D4EB2F165667C5), UINT64_C(0x9E3779B1)};
    uint8_t secret[192];
    uint64_t hash = count * RBT_PRIME;
    size_t stripe, stripes = (count - 1) / 64;
    int i, j;
    for (i = 0; i < 24; i++) {
        uint64_t word = rbt_read64(rbt_secret + 8 * i);
        word = i % 2 ? word - seed : word + seed;
        for (j = 0; j < 8; j++) secret[8 * i + j] = (uint8_t)(word >> 8 * j);
    }
    for (stripe = 0; stripe < stripes; stripe++) {
        rbt_accumulate(lanes, data + 64 * stripe, secret + 8 * (stripe % 16));
        if (stripe % 16 == 15) {
            for (i = 0; i < 8; i++)
                lanes[i] = (lanes[i] ^ lanes[i] >> 47 ^ rbt_read64(secret + 128 + 8 * i)) * UINT64_C(0x9E3779B1);
        }
    }
    rbt_accumulate(lanes, data + count - 64, secret + 121);
    for (i = 0; i < 4; i++) {
        hash += rbt_fold(lanes[2 * i] ^ rbt_read64(secret + 11 + 16 * i), lanes[2 * i + 1] ^ rbt_read64(secret + 19 + 16 * i));
    }
    return rbt_avalanche(hash);
}

static uint64_t rbt_hash(const uint8_t *data, size_t count, uint64_t seed) {
    uint64_t hash = count * RBT_PRIME;
    size_t i;
    if (count > 240) return rbt_hash_long(data, count, seed);
    if (count > 128) {
        for (i = 0; i < 8; i++) hash += rbt_mix16(data + 16 * i, 16 * i, seed);
        hash = rbt_avalanche(hash);
        for (i = 8; i < count / 16; i++) hash += rbt_mix16(data + 16 * i, 16 * (i - 8) + 3, seed);
        return rbt_avalanche(hash + rbt_mix16(data + count - 16, 119, seed));
    }
    if (count > 16) {
        for (i = 0; i <= (count - 1) / 32; i++) {
            hash += rbt_mix16(data + 16 * i, 32 * i, seed) + rbt_mix16(data + count - 16 * (i + 1), 32 * i + 16, seed);
        }
        return rbt_avalanche(hash);
    } else {
        uint64_t low = rbt_read64(data) ^ ((rbt_read64(rbt_secret + 24) ^ rbt_read64(rbt_secret + 32)) + seed);
        uint64_t high = rbt_read64(data + count - 8) ^ ((rbt_read64(rbt_secret + 40) ^ rbt_read64(rbt_secret + 48)) - seed);
        uint64_t swapped = 0;
        for (i = 0; i < 8; i++) swapped = swapped << 8 | (low >> 8 * i & 0xff);
        return rbt_avalanche(count + swapped + high + rbt_fold(low, high));
    }
}

/* ---- chunks ---- */

/* Data as a zstd frame: a header with a window of 128 KiB and the length, and blocks of up to 128 KiB as they are. */
static int rbt_put_frame(rbt_bytes *to, const rbt_bytes *data) {
#ifdef RBT_USE_ZSTD
    size_t room = ZSTD_compressBound(data->count), written;
    if (!rbt_reserve(to, room)) return 0;
    written = ZSTD_compress(to->data + to->count, room, data->data, data->count, 1);
    if (ZSTD_isError(written)) return 0;
    to->count += written;
    return 1;
#else
    static const uint8_t head[6] = {0x28, 0xb5, 0x2f, 0xfd, 0x80, 0x38};
    const size_t most = (size_t)1 << 17;
    size_t at = 0;
    int ok = rbt_put(to, head, sizeof head) && rbt_put_fixed(to, data->count, 4);
    do {
        size_t count = data->count - at < most ? data->count - at : most;
        int last = at + count == data->count;
        ok = ok && rbt_put_fixed(to, count << 3 | (size_t)last, 3) && rbt_put(to, data->data + at, count);
        at += count;
    } while (ok && at < data->count);
    return ok;
#endif
}

static rbt_status rbt_put_chunk(rbt_bytes *to, const rbt_bytes *data, uint64_t seed) {
    size_t bytes, i;
    to->count = 0;
    if (data->count > RBT_MOST_CHUNK_BYTES) return RBT_MISUSE;
    if (!rbt_put_fixed(to, 0, 4) || !rbt_put_fixed(to, data->count, 4) || !rbt_put_frame(to, data)) return RBT_MEMORY;
    bytes = to->count - 8;
    if (to->count + 8 > RBT_MOST_CHUNK_BYTES) return RBT_MISUSE;
    for (i = 0; i < 4; i++) to->data[i] = (uint8_t)(bytes >> 8 * i);
    return rbt_put_fixed(to, rbt_hash(to->data, to->count, seed), 8) ? RBT_OK : RBT_MEMORY;
}

/* ---- the writer ---- */

static void rbt_release(rbt_writer *w) {
    if (w->file) {
        fclose(w->file);
        remove(w->part);
    }
    free(w->sources);
    free(w->is_table);
    free(w->path);
    free(w->part);
    free(w->offsets.data);
    w->sources = NULL;
    w->is_table = NULL;
    w->path = w->part = NULL;
    w->file = NULL;
    memset(&w->offsets, 0, sizeof w->offsets);
}

/* The first error stays. What was written goes at once; memory that tiles read stays until the writer is finished. */
static rbt_status rbt_fail(rbt_writer *w, rbt_status status, const char *format, ...) {
    va_list values;
    if (w->status != RBT_OK) return w->status;
    w->status = status;
    va_start(values, format);
    vsnprintf(w->message, sizeof w->message, format, values);
    va_end(values);
    if (w->file) {
        fclose(w->file);
        remove(w->part);
        w->file = NULL;
    }
    return status;
}

static rbt_status rbt_no_memory(rbt_writer *w) { return rbt_fail(w, RBT_MEMORY, "no memory is left"); }

static rbt_status rbt_cannot_write(rbt_writer *w, const char *action) {
    return rbt_fail(w, RBT_IO, "%.150s: %s: %.60s", w->path, action, strerror(errno));
}

static rbt_status rbt_write(rbt_writer *w, const rbt_bytes *bytes) {
    if (w->status != RBT_OK) return w->status;
    if (fwrite(bytes->data, 1, bytes->count, w->file) != bytes->count) return rbt_cannot_write(w, "writing");
    w->position += bytes->count;
    return RBT_OK;
}

/* The place of a text among names, or -1. */
static int rbt_place(const char *text, const char *const *names) {
    int place;
    for (place = 0; names[place]; place++) {
        if (text && !strcmp(text, names[place])) return place;
    }
    return -1;
}

static rbt_status rbt_check_name(rbt_writer *w, const char *key, const char *text, const char *const *names) {
    if (rbt_place(text, names) >= 0) return RBT_OK;
    return rbt_fail(w, RBT_MISUSE, "%s \"%.60s\" is not known", key, text ? text : "");
}

/* Whether a text is UTF-8: no character cut off or longer than needed, no surrogates, nothing above U+10FFFF. */
static int rbt_is_utf8(const char *text) {
    static const uint32_t least[4] = {0, 0x80, 0x800, 0x10000};
    const uint8_t *at;
    for (at = (const uint8_t *)text; *at; at++) {
        int i, following = *at < 0x80 ? 0 : *at >> 5 == 0x6 ? 1 : *at >> 4 == 0xe ? 2 : *at >> 3 == 0x1e ? 3 : -1;
        uint32_t code = following > 0 ? *at & 0x3fu >> following : *at;
        if (following < 0) return 0;
        for (i = 0; i < following; i++) {
            at++;
            if (*at >> 6 != 0x2) return 0;
            code = code << 6 | (*at & 0x3fu);
        }
        if (code < least[following] || code >> 11 == 0xd800 >> 11 || code > 0x10ffff) return 0;
    }
    return 1;
}

static rbt_status rbt_check_text(rbt_writer *w, const char *key, const char *text) {
    return rbt_is_utf8(text) ? RBT_OK : rbt_fail(w, RBT_MISUSE, "%s is not UTF-8", key);
}

/* The structures, and the traversals of each. */
static const char *const rbt_accels[] = {"bvh", "wide-bvh", "kd", "grid", "two-level", NULL};
static const char *const rbt_traversals[][5] = {{"stack", "parent-link", "restart-trail", NULL},
                                                {"stack", "short-stack", NULL},
                                                {"stack", "restart", "push-down", "backtrack", NULL},
                                                {"dda", NULL},
                                                {"stack", "short-stack", NULL}};
static const char *const rbt_formats[] = {"full-4", "full-8", "compressed-8", "compressed-8-pairs", "adreno-8", NULL};
static const char *const rbt_fetches[] = {"single", "pair", NULL};
static const char *const rbt_loops[] = {"while-while", "if-if", "single-loop", NULL};
/* Kinds of ray sets, and the kind that each starts from. */
static const char *const rbt_kinds[] = {"primary",           "shadow",            "soft-shadow", "reflection",
                                        "reflection-shadow", "ambient-occlusion", "diffuse",     "diffuse-shadow", NULL};
static const int rbt_starts_from[] = {-1, 0, 0, 0, 3, 0, 0, 6};
static const int rbt_goes_to_light[] = {0, 1, 1, 0, 1, 0, 0, 1};

static rbt_status rbt_check_header(rbt_writer *w, const rbt_header *h) {
    uint32_t widest = h->width > h->height ? h->width : h->height;
    size_t i, j;
    if (widest ? !h->width || !h->height || widest > 32768 || h->rays : !h->rays || h->rays > UINT32_C(1) << 30)
        return rbt_fail(w, RBT_MISUSE, "an image of 1 to 32768 pixels per edge or a list of 1 to 2^30 rays expected");
    if (!h->generator || !h->scene) return rbt_fail(w, RBT_MISUSE, "generator and scene are needed");
    if (rbt_check_text(w, "generator", h->generator) || rbt_check_text(w, "scene", h->scene) || (h->more && rbt_check_text(w, "more", h->more)))
        return w->status;
    if (rbt_check_name(w, "accel", h->accel, rbt_accels)) return w->status;
    if (rbt_place(h->traversal, rbt_traversals[rbt_place(h->accel, rbt_accels)]) < 0)
        return rbt_fail(w, RBT_MISUSE, "%s has no traversal \"%.60s\"", h->accel, h->traversal ? h->traversal : "");
    if (rbt_check_name(w, "node_fetch", h->node_fetch, rbt_fetches)) return w->status;
    if (rbt_check_name(w, "loop_structure", h->loop_structure, rbt_loops)) return w->status;
    if (h->node_format && rbt_check_name(w, "node_format", h->node_format, rbt_formats)) return w->status;
    if (strcmp(h->accel, "two-level") && !h->node_format != !!strcmp(h->accel, "wide-bvh"))
        return rbt_fail(w, RBT_MISUSE, "node_format belongs to wide-bvh, perhaps to two-level, and to no other");
    if (!strcmp(h->traversal, "short-stack") && !h->node_format) return rbt_fail(w, RBT_MISUSE, "a short-stack without a node_format");
    if (h->stack_entries > 65536 || h->short_stack > 65536)
        return rbt_fail(w, RBT_MISUSE, "stacks of 0 to 65536 entries expected");
    if (h->trail_bits != 0 && h->trail_bits != 32 && h->trail_bits != 64)
        return rbt_fail(w, RBT_MISUSE, "trail_bits of %u, 0, 32 or 64 expected", (unsigned)h->trail_bits);
    if (!isfinite(h->sah_costs[0]) || !isfinite(h->sah_costs[1]))
        return rbt_fail(w, RBT_MISUSE, "sah_costs are not finite");
    if (h->ray_set_count < 1 || h->ray_set_count > 1024)
        return rbt_fail(w, RBT_MISUSE, "%lu ray sets, 1 to 1024 expected", (unsigned long)h->ray_set_count);
    w->sources = (int32_t *)malloc(h->ray_set_count * sizeof *w->sources);
    w->is_table = (uint8_t *)malloc(h->ray_set_count);
    if (!w->sources || !w->is_table) return rbt_no_memory(w);
    w->set_count = h->ray_set_count;
    for (i = 0; i < h->ray_set_count; i++) {
        const rbt_ray_set *set = &h->ray_sets[i];
        int kind = rbt_place(set->kind, rbt_kinds);
        if (kind < 0) return rbt_check_name(w, "ray set", set->kind, rbt_kinds);
        w->is_table[i] = kind > 1;
        w->sources[i] = -1;
        for (j = 0; j < h->ray_set_count && w->sources[i] < 0; j++) {
            int other = rbt_place(h->ray_sets[j].kind, rbt_kinds);
            int same_sample = other == 0 || h->ray_sets[j].sample == set->sample;
            if (other >= 0 && other == rbt_starts_from[kind] && same_sample) w->sources[i] = (int32_t)j;
        }
        if (kind > 1 && (w->sources[i] < 0 || w->sources[i] > (int32_t)i))
            return rbt_fail(w, RBT_MISUSE, "ray set %lu (%s) without the set before it from whose hits it starts", (unsigned long)i,
                            set->kind);
    }
    return RBT_OK;
}

static rbt_status rbt_check_tree(rbt_writer *w, const rbt_tree *tree, int is_wide, int is_grid) {
    uint32_t i;
    if (tree->node_count < 1 || tree->node_count > RBT_MOST_IDS || tree->reference_count > RBT_MOST_IDS || tree->triangles > RBT_MOST_IDS)
        return rbt_fail(w, RBT_MISUSE, "a tree of %lu nodes, %lu references and %lu triangles, at least a node and at most %lu of each expected",
                        (unsigned long)tree->node_count, (unsigned long)tree->reference_count, (unsigned long)tree->triangles,
                        (unsigned long)RBT_MOST_IDS);
    for (i = 0; i < tree->node_count; i++) {
        rbt_node node = tree->nodes[i];
        uint64_t end = (uint64_t)node.first + node.count;
        if (is_wide ? node.kind != RBT_WIDE : node.kind != RBT_LEAF && (is_grid || node.kind != RBT_INNER || node.count != 2))
            return rbt_fail(w, RBT_MISUSE, "node %lu is of a kind that this structure does not have", (unsigned long)i);
        if (node.kind == RBT_LEAF ? end > tree->reference_count : node.count && (node.first <= i || end > tree->node_count))
            return rbt_fail(w, RBT_MISUSE, "node %lu leads to %lu from %lu: children lie behind it, and nothing leads outside", (unsigned long)i,
                            (unsigned long)node.count, (unsigned long)node.first);
        if (node.kind == RBT_WIDE && (node.count > 8 || node.leaves > 8 - node.count))
            return rbt_fail(w, RBT_MISUSE, "node %lu has more than 8 children", (unsigned long)i);
    }
    for (i = 0; i < tree->reference_count; i++) {
        if (tree->references[i] >= tree->triangles)
            return rbt_fail(w, RBT_MISUSE, "reference %lu is to %lu of %lu", (unsigned long)i, (unsigned long)tree->references[i],
                            (unsigned long)tree->triangles);
    }
    for (i = 0; i < tree->second_count; i++) {
        uint32_t least = i ? tree->seconds[i - 1] + 2 : 1;
        if (tree->seconds[i] < least || tree->seconds[i] >= tree->reference_count)
            return rbt_fail(w, RBT_MISUSE, "place %lu cannot be second to the one before", (unsigned long)tree->seconds[i]);
    }
    return RBT_OK;
}

static int rbt_put_tree(rbt_bytes *to, const rbt_tree *tree, int has_pairs) {
    int64_t link = 0, place = 0, previous = 0;
    uint32_t i;
    int ok = rbt_put_varint(to, tree->node_count) && rbt_put_varint(to, tree->reference_count) && rbt_put_varint(to, tree->triangles);
    for (i = 0; ok && i < tree->node_count; i++) {
        rbt_node node = tree->nodes[i];
        int is_leaf = node.kind == RBT_LEAF;
        int64_t *before = is_leaf ? &place : &link;
        ok = rbt_put_varint(to, rbt_zigzag((int64_t)node.first - *before) << 1 | (uint64_t)is_leaf);
        if (node.kind != RBT_INNER) ok = ok && rbt_put_varint(to, node.count);
        if (node.kind == RBT_WIDE) ok = ok && rbt_put_varint(to, node.leaves);
        *before = (int64_t)node.first + (node.kind == RBT_INNER ? 0 : (int64_t)node.count);
    }
    for (i = 0; ok && i < tree->reference_count; i++) {
        ok = rbt_put_varint(to, rbt_zigzag((int64_t)tree->references[i] - previous));
        previous = tree->references[i];
    }
    if (has_pairs) ok = ok && rbt_put_varint(to, tree->second_count);
    for (i = 0; ok && has_pairs && i < tree->second_count; i++) {
        ok = rbt_put_varint(to, tree->seconds[i] - (i ? tree->seconds[i - 1] : 0));
    }
    return ok;
}

static int rbt_put_text(rbt_bytes *to, const char *text) { return rbt_put(to, text, strlen(text)); }

/* A number as JSON, whatever the locale's decimal point. */
static int rbt_put_number(rbt_bytes *to, double value) {
    char text[40], *at;
    snprintf(text, sizeof text, "%.17g", value);
    for (at = text; *at; at++) {
        if (!strchr("0123456789+-e", *at)) *at = '.';
    }
    return rbt_put_text(to, text);
}

static int rbt_put_string(rbt_bytes *to, const char *text) {
    int ok = rbt_put_text(to, "\"");
    for (; ok && *text; text++) {
        char escaped[8];
        if (*text == '"' || *text == '\\' || (unsigned char)*text < 0x20) {
            snprintf(escaped, sizeof escaped, "\\u%04x", (unsigned)(unsigned char)*text);
            ok = rbt_put_text(to, escaped);
        } else {
            ok = rbt_put(to, text, 1);
        }
    }
    return ok && rbt_put_text(to, "\"");
}

static int rbt_put_key(rbt_bytes *to, const char *key, const char *value) {
    return rbt_put_text(to, ",\"") && rbt_put_text(to, key) && rbt_put_text(to, "\":") && rbt_put_string(to, value);
}

static int rbt_put_count(rbt_bytes *to, const char *before, uint32_t value) {
    char digits[24];
    snprintf(digits, sizeof digits, "%lu", (unsigned long)value);
    return rbt_put_text(to, before) && rbt_put_text(to, digits);
}

static int rbt_put_header(rbt_bytes *to, const rbt_header *h, uint32_t triangles) {
    char hash[20];
    size_t i;
    int ok;
    snprintf(hash, sizeof hash, "%08lx%08lx", (unsigned long)(h->scene_hash >> 32), (unsigned long)(h->scene_hash & UINT32_MAX));
    ok = rbt_put_text(to, "{\"generator\":") && rbt_put_string(to, h->generator) && rbt_put_key(to, "scene", h->scene)
         && rbt_put_key(to, "scene_hash", hash) && rbt_put_count(to, ",\"triangles\":", triangles);
    if (h->width) {
        ok = ok && rbt_put_count(to, ",\"frame\":{\"image\":{\"width\":", h->width) && rbt_put_count(to, ",\"height\":", h->height);
    } else {
        ok = ok && rbt_put_count(to, ",\"frame\":{\"list\":{\"rays\":", h->rays);
    }
    ok = ok && rbt_put_text(to, "}},\"ray_sets\":");
    for (i = 0; ok && i < h->ray_set_count; i++) {
        const rbt_ray_set *set = &h->ray_sets[i];
        int kind = rbt_place(set->kind, rbt_kinds);
        ok = rbt_put_text(to, i ? "," : "[");
        if (kind <= 1) {
            ok = ok && rbt_put_string(to, set->kind);
        } else {
            ok = ok && rbt_put_text(to, "{\"kind\":") && rbt_put_string(to, set->kind) && rbt_put_count(to, ",\"sample\":", set->sample);
            if (rbt_goes_to_light[kind]) ok = ok && rbt_put_count(to, ",\"light\":", set->light);
            ok = ok && rbt_put_text(to, "}");
        }
    }
    ok = ok && rbt_put_text(to, "]") && rbt_put_key(to, "accel", h->accel) && rbt_put_key(to, "traversal", h->traversal);
    if (h->node_format) ok = ok && rbt_put_key(to, "node_format", h->node_format);
    ok = ok && rbt_put_key(to, "node_fetch", h->node_fetch) && rbt_put_key(to, "loop_structure", h->loop_structure)
         && rbt_put_count(to, ",\"stack_entries\":", h->stack_entries) && rbt_put_count(to, ",\"short_stack\":", h->short_stack);
    if (h->trail_bits) ok = ok && rbt_put_count(to, ",\"trail_bits\":", h->trail_bits);
    ok = ok && rbt_put_text(to, ",\"sah_costs\":[") && rbt_put_number(to, h->sah_costs[0]) && rbt_put_text(to, ",")
         && rbt_put_number(to, h->sah_costs[1]) && rbt_put_count(to, "],\"depth\":", h->depth);
    if (h->closest_hit_shadows) ok = ok && rbt_put_key(to, "shadow_query", "closest-hit");
    if (h->flat_normals) ok = ok && rbt_put_text(to, ",\"normals\":false");
    if (h->more) ok = ok && rbt_put_text(to, ",") && rbt_put_text(to, h->more);
    return ok && rbt_put_text(to, "}");
}

static char *rbt_copy(const char *text, const char *ending) {
    char *copy = (char *)malloc(strlen(text) + strlen(ending) + 1);
    if (copy) strcat(strcpy(copy, text), ending);
    return copy;
}

/* Writes header and structure, both encoded. */
static rbt_status rbt_open(rbt_writer *w, const char *path, const rbt_header *h, const rbt_bytes *structure) {
    rbt_bytes text = {NULL, 0, 0}, bytes = {NULL, 0, 0};
    rbt_status status = RBT_OK;
    static const uint8_t magic[8] = {'R', 'B', 'T', 'R', 'A', 'C', 'E', 1};
    if (!rbt_put_header(&text, h, w->triangles) || !rbt_put(&bytes, magic, 8) || !rbt_put_fixed(&bytes, text.count, 4)
        || !rbt_put(&bytes, text.data, text.count) || !rbt_put_fixed(&bytes, rbt_hash(bytes.data, bytes.count, 0), 8)) {
        status = rbt_no_memory(w);
    } else if (text.count > UINT32_C(1) << 20) {
        status = rbt_fail(w, RBT_MISUSE, "a header of %lu bytes, at most 2^20 fit", (unsigned long)text.count);
    }
    if (status == RBT_OK) {
        w->path = rbt_copy(path, "");
        w->part = rbt_copy(path, ".part");
        if (!w->path || !w->part) status = rbt_no_memory(w);
    }
    if (status == RBT_OK && !(w->file = fopen(w->part, "wb"))) status = rbt_cannot_write(w, "creating a file beside it");
    if (status == RBT_OK) status = rbt_write(w, &bytes);
    if (status == RBT_OK) {
        status = rbt_put_chunk(&bytes, structure, 1);
        if (status != RBT_OK) {
            rbt_fail(w, status, status == RBT_MEMORY ? "no memory is left" : "a tree too large for a trace file");
        } else if (!rbt_put_fixed(&w->offsets, w->position, 8)) {
            status = rbt_no_memory(w);
        } else {
            status = rbt_write(w, &bytes);
        }
    }
    free(text.data);
    free(bytes.data);
    return status;
}

static void rbt_set_frame(rbt_writer *w, const rbt_header *h) {
    w->width = h->width;
    w->height = h->height;
    w->rays = h->rays;
    w->tiles = h->width ? ((h->width + RBT_TILE_EDGE - 1) / RBT_TILE_EDGE) * ((h->height + RBT_TILE_EDGE - 1) / RBT_TILE_EDGE)
                        : (h->rays + RBT_TILE_RAYS - 1) / RBT_TILE_RAYS;
}

static void rbt_set_limits(rbt_writer *w, const rbt_header *h, uint64_t nodes, uint64_t node_steps, uint64_t instances, uint64_t references) {
    uint64_t stack = h->stack_entries > h->short_stack ? h->stack_entries : h->short_stack;
    uint64_t *limits = w->id_limits;
    limits[RBT_POP] = limits[RBT_PUSH] = stack;
    limits[RBT_RESTART] = limits[RBT_UP] = nodes;
    limits[RBT_NODE] = node_steps;
    limits[RBT_INSTANCE] = instances;
    limits[RBT_PRIMITIVE] = limits[RBT_ANY_HIT] = references;
}

rbt_status rbt_begin(rbt_writer *w, const char *path, const rbt_header *h, const rbt_tree *tree) {
    rbt_bytes structure = {NULL, 0, 0};
    int is_wide, has_pairs;
    memset(w, 0, sizeof *w);
    if (rbt_check_header(w, h)) return w->status;
    is_wide = !strcmp(h->accel, "wide-bvh");
    has_pairs = is_wide && !strcmp(h->node_format, "compressed-8-pairs");
    if (!strcmp(h->accel, "two-level")) return rbt_fail(w, RBT_MISUSE, "two-level begins with rbt_begin_two_level");
    if (rbt_check_tree(w, tree, is_wide, !strcmp(h->accel, "grid"))) return w->status;
    rbt_set_frame(w, h);
    w->triangles = tree->triangles;
    {
        uint32_t nodes = tree->node_count;
        /* A pair reads the sibling too; the root has none. */
        uint32_t node_steps = strcmp(h->node_fetch, "pair") || nodes < 2 ? nodes : nodes - 1;
        rbt_set_limits(w, h, nodes, node_steps, 0, tree->reference_count);
    }
    if (rbt_put_tree(&structure, tree, has_pairs)) {
        rbt_open(w, path, h, &structure);
    } else {
        rbt_no_memory(w);
    }
    free(structure.data);
    return w->status;
}

rbt_status rbt_begin_two_level(rbt_writer *w, const char *path, const rbt_header *h, const rbt_tree *tlas, const uint32_t *meshes,
                               const rbt_tree *blases, uint32_t blas_count) {
    rbt_bytes structure = {NULL, 0, 0};
    uint64_t nodes, references = 0, triangles = 0;
    int64_t previous = 0;
    int is_wide = h->node_format != NULL, has_pairs, ok;
    uint32_t i;
    memset(w, 0, sizeof *w);
    if (rbt_check_header(w, h)) return w->status;
    if (strcmp(h->accel, "two-level")) return rbt_fail(w, RBT_MISUSE, "%s begins with rbt_begin", h->accel);
    has_pairs = is_wide && !strcmp(h->node_format, "compressed-8-pairs");
    /* With a fetch in pairs the TLAS is binary. */
    if (rbt_check_tree(w, tlas, is_wide && !strcmp(h->node_fetch, "single"), 0)) return w->status;
    nodes = tlas->node_count;
    for (i = 0; i < blas_count; i++) {
        if (rbt_check_tree(w, &blases[i], is_wide, 0)) return w->status;
        if (blases[i].reference_count != blases[i].triangles)
            return rbt_fail(w, RBT_MISUSE, "BLAS %lu has %lu references to %lu triangles, one to each expected", (unsigned long)i,
                            (unsigned long)blases[i].reference_count, (unsigned long)blases[i].triangles);
        nodes += nodes % 2 + blases[i].node_count;
        references += blases[i].reference_count;
        if (nodes > RBT_MOST_IDS || references > RBT_MOST_IDS)
            return rbt_fail(w, RBT_MISUSE, "more than %lu nodes or references in all trees", (unsigned long)RBT_MOST_IDS);
    }
    ok = rbt_put_tree(&structure, tlas, 0);
    for (i = 0; ok && i < tlas->triangles; i++) {
        if (meshes[i] >= blas_count) {
            free(structure.data);
            return rbt_fail(w, RBT_MISUSE, "an instance of mesh %lu of %lu", (unsigned long)meshes[i], (unsigned long)blas_count);
        }
        triangles += blases[meshes[i]].triangles;
        ok = rbt_put_varint(&structure, rbt_zigzag((int64_t)meshes[i] - previous));
        previous = meshes[i];
    }
    ok = ok && rbt_put_varint(&structure, blas_count);
    for (i = 0; ok && i < blas_count; i++) ok = rbt_put_tree(&structure, &blases[i], has_pairs);
    if (triangles > RBT_MOST_IDS) {
        rbt_fail(w, RBT_MISUSE, "more than %lu triangles in all instances", (unsigned long)RBT_MOST_IDS);
    } else if (!ok) {
        rbt_no_memory(w);
    } else {
        rbt_set_frame(w, h);
        w->triangles = (uint32_t)triangles;
        rbt_set_limits(w, h, nodes, nodes, tlas->triangles, references);
        rbt_open(w, path, h, &structure);
    }
    free(structure.data);
    return w->status;
}

rbt_status rbt_write_tile(rbt_writer *w, const rbt_tile *tile) {
    if (w->status != RBT_OK) return w->status;
    if (!w->file) return rbt_fail(w, RBT_MISUSE, "no trace is open");
    if (tile->writer != w) return rbt_fail(w, RBT_MISUSE, "tile %lu is of another writer", (unsigned long)tile->index);
    if (tile->status != RBT_OK) return rbt_fail(w, tile->status, "%.255s", tile->message);
    if (!tile->ended) return rbt_fail(w, RBT_MISUSE, "tile %lu is written before rbt_tile_end", (unsigned long)tile->index);
    if (tile->index != w->written)
        return rbt_fail(w, RBT_MISUSE, "tile %lu is written where tile %lu is expected", (unsigned long)tile->index, (unsigned long)w->written);
    if (!rbt_put_fixed(&w->offsets, w->position, 8)) return rbt_no_memory(w);
    if (rbt_write(w, &tile->chunk)) return w->status;
    w->steps += tile->steps;
    w->written++;
    return RBT_OK;
}

rbt_status rbt_finish(rbt_writer *w, uint64_t stalls) {
    static const uint8_t magic[8] = {'R', 'B', 'T', 'R', 'E', 'N', 'D', 1};
    uint64_t index = w->position;
    rbt_bytes trailer = {NULL, 0, 0};
    if (w->status == RBT_OK && !w->file) rbt_fail(w, RBT_MISUSE, "no trace is open");
    if (w->status == RBT_OK && w->written != w->tiles)
        rbt_fail(w, RBT_MISUSE, "%lu tiles of %lu are missing", (unsigned long)(w->tiles - w->written), (unsigned long)w->tiles);
    if (w->status == RBT_OK) {
        int ok = rbt_put_fixed(&w->offsets, rbt_hash(w->offsets.data, w->offsets.count, 2), 8) && rbt_put_fixed(&trailer, index, 8)
                 && rbt_put_fixed(&trailer, w->tiles, 8) && rbt_put_fixed(&trailer, w->steps, 8) && rbt_put_fixed(&trailer, stalls, 8)
                 && rbt_put_fixed(&trailer, rbt_hash(trailer.data, trailer.count, 3), 8) && rbt_put(&trailer, magic, 8);
        if (!ok) rbt_no_memory(w);
    }
    if (w->status == RBT_OK) rbt_write(w, &w->offsets);
    if (w->status == RBT_OK) rbt_write(w, &trailer);
    free(trailer.data);
    if (w->status == RBT_OK) {
        int flushed = !fflush(w->file);
        int closed = !fclose(w->file);
        w->file = NULL;
#ifdef _WIN32
        remove(w->path); /* there, rename does not replace */
#endif
        if (!flushed || !closed) {
            rbt_cannot_write(w, "writing");
        } else if (rename(w->part, w->path)) {
            rbt_cannot_write(w, "renaming the finished file");
        }
        if (w->status != RBT_OK) remove(w->part);
    }
    rbt_release(w);
    return w->status;
}

void rbt_abandon(rbt_writer *w) {
    if (w->file) rbt_fail(w, RBT_MISUSE, "no trace is open");
    rbt_release(w);
}

/* ---- tiles ---- */

static rbt_status rbt_fail_tile(rbt_tile *t, rbt_status status, const char *format, ...) {
    va_list values;
    if (t->status != RBT_OK) return t->status;
    t->status = status;
    va_start(values, format);
    vsnprintf(t->message, sizeof t->message, format, values);
    va_end(values);
    return status;
}

void rbt_tile_init(rbt_tile *t, const rbt_writer *writer) {
    memset(t, 0, sizeof *t);
    t->writer = writer;
}

void rbt_tile_free(rbt_tile *t) {
    free(t->rays);
    free(t->bytes.data);
    free(t->data.data);
    free(t->chunk.data);
    rbt_tile_init(t, t->writer);
}

rbt_status rbt_tile_begin(rbt_tile *t, uint32_t index) {
    const rbt_writer *w = t->writer;
    t->status = RBT_OK;
    t->message[0] = 0;
    t->index = index;
    t->ended = 0;
    t->ray = NULL;
    t->bytes.count = 0;
    t->steps = 0;
    if (!w->sources) return rbt_fail_tile(t, RBT_MISUSE, "no trace is open");
    if (index >= w->tiles) return rbt_fail_tile(t, RBT_MISUSE, "tile %lu of %lu", (unsigned long)index, (unsigned long)w->tiles);
    if (w->width) {
        uint32_t columns = (w->width + RBT_TILE_EDGE - 1) / RBT_TILE_EDGE;
        t->x = index % columns * RBT_TILE_EDGE;
        t->y = index / columns * RBT_TILE_EDGE;
        t->width = w->width - t->x < RBT_TILE_EDGE ? w->width - t->x : RBT_TILE_EDGE;
        t->height = w->height - t->y < RBT_TILE_EDGE ? w->height - t->y : RBT_TILE_EDGE;
    } else {
        t->x = index * RBT_TILE_RAYS;
        t->y = 0;
        t->width = w->rays - t->x < RBT_TILE_RAYS ? w->rays - t->x : RBT_TILE_RAYS;
        t->height = 1;
    }
    if (!t->rays) t->rays = (struct rbt_ray *)malloc(w->set_count * RBT_TILE_RAYS * sizeof *t->rays);
    if (!t->rays) return rbt_fail_tile(t, RBT_MEMORY, "no memory is left");
    memset(t->rays, 0, w->set_count * RBT_TILE_RAYS * sizeof *t->rays);
    return RBT_OK;
}

rbt_status rbt_begin_ray(rbt_tile *t, size_t set, uint32_t ray) {
    uint32_t rays = t->width * t->height;
    if (t->status != RBT_OK) return t->status;
    if (!t->rays || t->ended || t->ray) return rbt_fail_tile(t, RBT_MISUSE, "a ray begins where none can");
    if (set >= t->writer->set_count)
        return rbt_fail_tile(t, RBT_MISUSE, "ray set %lu of %lu", (unsigned long)set, (unsigned long)t->writer->set_count);
    if (ray >= rays) return rbt_fail_tile(t, RBT_MISUSE, "ray %lu of a tile of %lu", (unsigned long)ray, (unsigned long)rays);
    t->ray = &t->rays[set * RBT_TILE_RAYS + ray];
    if (t->ray->recorded)
        return rbt_fail_tile(t, RBT_MISUSE, "ray %lu of set %lu of tile %lu comes twice", (unsigned long)ray, (unsigned long)set, (unsigned long)t->index);
    t->ray->recorded = 1;
    t->ray->offset = t->bytes.count;
    memset(t->previous, 0, sizeof t->previous);
    return RBT_OK;
}

rbt_status rbt_step(rbt_tile *t, rbt_op op, uint32_t id) {
    /* Pop, Push: 0; Restart, Up, Node: 1; Instance: 2; Primitive, AnyHit: 3. */
    static const uint8_t kinds[8] = {0, 1, 1, 1, 0, 2, 3, 3};
    static const char *const names[8] = {"Pop", "Restart", "Up", "Node", "Push", "Instance", "Primitive", "AnyHit"};
    uint32_t *previous;
    if (t->status != RBT_OK) return t->status;
    if (!t->ray) return rbt_fail_tile(t, RBT_MISUSE, "a step outside of a ray");
    if ((unsigned)op > 7) return rbt_fail_tile(t, RBT_MISUSE, "a step of kind %u, below 8 expected", (unsigned)op);
    if (id >= t->writer->id_limits[op])
        return rbt_fail_tile(t, RBT_MISUSE, "a %s step with id %lu, below %lu expected", names[op], (unsigned long)id,
                             (unsigned long)t->writer->id_limits[op]);
    if (t->ray->steps == RBT_MOST_TILE_STEPS) return rbt_fail_tile(t, RBT_MISUSE, "more than 2^26 steps in a ray set of a tile");
    previous = &t->previous[kinds[op]];
    if (!rbt_put_varint(&t->bytes, rbt_zigzag((int64_t)id - (int64_t)*previous) << 3 | (uint64_t)op))
        return rbt_fail_tile(t, RBT_MEMORY, "no memory is left");
    *previous = id;
    t->ray->steps++;
    return RBT_OK;
}

rbt_status rbt_end_ray(rbt_tile *t, uint32_t triangle) {
    if (t->status != RBT_OK) return t->status;
    if (!t->ray) return rbt_fail_tile(t, RBT_MISUSE, "a ray ends where none began");
    if (triangle != RBT_MISS && triangle >= t->writer->triangles)
        return rbt_fail_tile(t, RBT_MISUSE, "a hit of triangle %lu of %lu", (unsigned long)triangle, (unsigned long)t->writer->triangles);
    t->ray->hit = triangle == RBT_MISS ? 0 : triangle + 1;
    t->ray->length = t->bytes.count - t->ray->offset;
    t->ray = NULL;
    return RBT_OK;
}

/* The hit of a ray that was not recorded: 1 plus the number of triangles where the ray that it would start from hit. */
static rbt_status rbt_leave_out(rbt_tile *t, size_t set, uint32_t ray) {
    const rbt_writer *w = t->writer;
    int32_t source = w->sources[set];
    int due = source < 0;
    if (source >= 0) {
        uint32_t hit = t->rays[(size_t)source * RBT_TILE_RAYS + ray].hit;
        int source_hit = hit > 0 && hit <= w->triangles;
        due = source_hit && !w->is_table[set];
        if (source_hit) t->rays[set * RBT_TILE_RAYS + ray].hit = w->triangles + 1;
    }
    if (!due) return RBT_OK;
    return rbt_fail_tile(t, RBT_MISUSE, "ray %lu of set %lu of tile %lu is missing", (unsigned long)ray, (unsigned long)set, (unsigned long)t->index);
}

rbt_status rbt_tile_end(rbt_tile *t) {
    uint32_t rays = t->width * t->height, i;
    size_t set;
    int ok = 1;
    if (t->status != RBT_OK) return t->status;
    if (!t->writer->sources) return rbt_fail_tile(t, RBT_MISUSE, "no trace is open");
    if (!t->rays || t->ended || t->ray) return rbt_fail_tile(t, RBT_MISUSE, "a tile ends where it cannot");
    t->data.count = 0;
    for (set = 0; ok && set < t->writer->set_count; set++) {
        struct rbt_ray *own = t->rays + set * RBT_TILE_RAYS;
        uint64_t steps = 0;
        int64_t previous = 0;
        for (i = 0; ok && i < rays; i++) {
            if (!own[i].recorded && rbt_leave_out(t, set, i)) return t->status;
            steps += own[i].steps;
            ok = rbt_put_varint(&t->data, own[i].steps);
        }
        for (i = 0; ok && i < rays; i++) {
            ok = rbt_put_varint(&t->data, rbt_zigzag((int64_t)own[i].hit - previous));
            previous = own[i].hit;
        }
        for (i = 0; ok && i < rays; i++) {
            if (own[i].length) ok = rbt_put(&t->data, t->bytes.data + own[i].offset, own[i].length);
        }
        if (steps > RBT_MOST_TILE_STEPS) return rbt_fail_tile(t, RBT_MISUSE, "more than 2^26 steps in a ray set of a tile");
        t->steps += steps;
    }
    if (!ok) return rbt_fail_tile(t, RBT_MEMORY, "no memory is left");
    switch (rbt_put_chunk(&t->chunk, &t->data, UINT64_C(1) << 32 | t->index)) {
    case RBT_OK: break;
    case RBT_MISUSE: return rbt_fail_tile(t, RBT_MISUSE, "tile %lu is too large for a trace file", (unsigned long)t->index);
    default: return rbt_fail_tile(t, RBT_MEMORY, "no memory is left");
    }
    t->ended = 1;
    return RBT_OK;
}

#ifdef __cplusplus
}
#endif
#undef RBT_MOST_IDS
#undef RBT_MOST_CHUNK_BYTES
#undef RBT_MOST_TILE_STEPS
#undef RBT_TILE_EDGE
#undef RBT_TILE_RAYS
#undef RBT_PRIME
#endif
