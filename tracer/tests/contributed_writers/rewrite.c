/* Writes the trace that a listing on standard input tells of, through the writer in C: rewrite FILE.rbt < listing */
#define RBT_WRITER_IMPLEMENTATION
#include "../../contrib/rbt_writer.h"

static char words[64][40];
static int word_count;

static void line(char *to, int room) {
    if (!fgets(to, room, stdin)) exit(3);
    to[strcspn(to, "\n")] = 0;
}

/* A word that stays. */
static const char *word(void) {
    if (word_count == 64 || scanf("%39s", words[word_count]) != 1) exit(3);
    return words[word_count++];
}

static long long number(void) {
    long long value;
    if (scanf("%lld", &value) != 1) exit(3);
    return value;
}

static double real(void) {
    double value;
    if (scanf("%lf", &value) != 1) exit(3);
    return value;
}

static void *room(size_t count, size_t bytes) {
    void *memory = calloc(count + 1, bytes);
    if (!memory) exit(3);
    return memory;
}

static uint32_t *numbers(uint32_t count) {
    uint32_t *list = (uint32_t *)room(count, sizeof *list), i;
    for (i = 0; i < count; i++) list[i] = (uint32_t)number();
    return list;
}

static rbt_tree tree(void) {
    rbt_tree read;
    rbt_node *nodes;
    uint32_t i;
    read.node_count = (uint32_t)number();
    nodes = (rbt_node *)room(read.node_count, sizeof *nodes);
    for (i = 0; i < read.node_count; i++) {
        long long kind = number(), first = number(), count = number(), leaves = number();
        nodes[i] = kind == 0 ? rbt_inner((uint32_t)first) : rbt_leaf((uint32_t)first, (uint32_t)count);
        if (kind == 2) nodes[i] = rbt_wide((uint32_t)first, (uint32_t)count, (uint32_t)leaves);
    }
    read.nodes = nodes;
    read.reference_count = (uint32_t)number();
    read.references = numbers(read.reference_count);
    read.second_count = (uint32_t)number();
    read.seconds = numbers(read.second_count);
    read.triangles = (uint32_t)number();
    return read;
}

int main(int count, char **arguments) {
    static char generator[200], scene[200], more[400];
    rbt_ray_set sets[32];
    rbt_header header;
    rbt_writer writer;
    rbt_tile tile;
    long long tiles;
    size_t i;
    if (count != 2) return 3;
    memset(&header, 0, sizeof header);
    line(generator, sizeof generator);
    line(scene, sizeof scene);
    line(more, sizeof more);
    header.generator = generator;
    header.scene = scene;
    header.more = *more ? more : NULL;
    header.scene_hash = (uint64_t)number();
    header.width = (uint32_t)number();
    header.height = (uint32_t)number();
    header.rays = (uint32_t)number();
    header.ray_set_count = (size_t)number();
    header.ray_sets = sets;
    for (i = 0; i < header.ray_set_count && i < 32; i++) {
        sets[i].kind = word();
        sets[i].sample = (uint32_t)number();
        sets[i].light = (uint32_t)number();
    }
    header.accel = word();
    header.traversal = word();
    header.node_format = word();
    if (!strcmp(header.node_format, "-")) header.node_format = NULL;
    header.node_fetch = word();
    header.loop_structure = word();
    header.stack_entries = (uint32_t)number();
    header.short_stack = (uint32_t)number();
    header.trail_bits = (uint32_t)number();
    header.sah_costs[0] = real();
    header.sah_costs[1] = real();
    header.depth = (uint32_t)number();
    header.closest_hit_shadows = (int)number();
    header.flat_normals = (int)number();
    {
        rbt_tree first = tree();
        uint32_t *meshes = numbers((uint32_t)number()), blas_count = (uint32_t)number(), blas;
        rbt_tree *blases = (rbt_tree *)room(blas_count, sizeof *blases);
        for (blas = 0; blas < blas_count; blas++) blases[blas] = tree();
        if (strcmp(header.accel, "two-level")) {
            rbt_begin(&writer, arguments[1], &header, &first);
        } else {
            rbt_begin_two_level(&writer, arguments[1], &header, &first, meshes, blases, blas_count);
        }
    }
    rbt_tile_init(&tile, &writer);
    for (tiles = number(); tiles > 0; tiles--) {
        long long rays;
        rbt_tile_begin(&tile, (uint32_t)number());
        for (rays = number(); rays > 0; rays--) {
            long long set = number(), ray = number(), triangle = number(), steps;
            rbt_begin_ray(&tile, (size_t)set, (uint32_t)ray);
            for (steps = number(); steps > 0; steps--) {
                long long op = number(), id = number();
                rbt_step(&tile, (rbt_op)op, (uint32_t)id);
            }
            rbt_end_ray(&tile, triangle < 0 ? RBT_MISS : (uint32_t)triangle);
        }
        rbt_tile_end(&tile);
        rbt_write_tile(&writer, &tile);
    }
    rbt_tile_free(&tile);
    if (rbt_finish(&writer, (uint64_t)number()) != RBT_OK) {
        fprintf(stderr, "%s\n", writer.message);
        return 1;
    }
    return 0;
}
