/* A small ray tracer of its own that writes a trace: cc -std=c99 example.c -o example && ./example hills.rbt
 *
 * Hills of triangles under a light, a BVH with boxes fetched in pairs, and a traversal with a stack. What writes the trace are the calls that
 * begin with rbt_. example.py traces the same scene. */
#define RBT_WRITER_IMPLEMENTATION
#include "rbt_writer.h"

enum { QUADS = 8, CORNERS = QUADS + 1, TRIANGLES = 2 * QUADS * QUADS, WIDTH = 70, HEIGHT = 64, LEAF = 4, STACK = 16 };

typedef struct ray {
    double origin[3], direction[3];
} ray;

typedef struct box {
    double least[3], most[3];
} box;

static double corners[TRIANGLES][3][3];
static uint32_t order[TRIANGLES]; /* triangles as the leaves have them: the references */
static rbt_node nodes[2 * TRIANGLES];
static box boxes[2 * TRIANGLES];
static uint32_t node_count = 1, depth;

static void make_hills(void) {
    static const int offsets[2][3][2] = {{{0, 0}, {1, 0}, {0, 1}}, {{1, 0}, {1, 1}, {0, 1}}};
    int t, corner;
    for (t = 0; t < TRIANGLES; t++) {
        for (corner = 0; corner < 3; corner++) {
            int x = t / 2 % QUADS + offsets[t % 2][corner][0], z = t / 2 / QUADS + offsets[t % 2][corner][1];
            corners[t][corner][0] = x;
            corners[t][corner][1] = (x * 7 + z * 13) % 5 * 0.25;
            corners[t][corner][2] = z;
        }
        order[t] = (uint32_t)t;
    }
}

static double middle(uint32_t triangle, int axis) {
    return corners[triangle][0][axis] + corners[triangle][1][axis] + corners[triangle][2][axis];
}

/* Makes `node` of references `first` to `first + count - 1`, halved along the longest axis of their box. */
static void build(uint32_t node, uint32_t first, uint32_t count, uint32_t level) {
    box *b = &boxes[node];
    uint32_t i, j, left;
    int axis, longest = 0, corner;
    for (axis = 0; axis < 3; axis++) {
        b->least[axis] = b->most[axis] = corners[order[first]][0][axis];
        for (i = first; i < first + count; i++) {
            for (corner = 0; corner < 3; corner++) {
                double at = corners[order[i]][corner][axis];
                if (at < b->least[axis]) b->least[axis] = at;
                if (at > b->most[axis]) b->most[axis] = at;
            }
        }
        if (b->most[axis] - b->least[axis] > b->most[longest] - b->least[longest]) longest = axis;
    }
    if (level > depth) depth = level;
    if (count <= LEAF) {
        nodes[node] = rbt_leaf(first, count);
        return;
    }
    for (i = first + 1; i < first + count; i++) {
        for (j = i; j > first && middle(order[j], longest) < middle(order[j - 1], longest); j--) {
            uint32_t other = order[j];
            order[j] = order[j - 1];
            order[j - 1] = other;
        }
    }
    left = node_count;
    node_count += 2;
    nodes[node] = rbt_inner(left);
    build(left, first, count / 2, level + 1);
    build(left + 1, first + count / 2, count - count / 2, level + 1);
}

/* Where the ray enters the box before `end`; -1 if it does not. */
static double enter(const box *b, const ray *r, double end) {
    double begin = 0;
    int axis;
    for (axis = 0; axis < 3; axis++) {
        double inverse = 1 / (r->direction[axis] != 0 ? r->direction[axis] : 1e-30);
        double low = (b->least[axis] - r->origin[axis]) * inverse, high = (b->most[axis] - r->origin[axis]) * inverse;
        if (low > high) {
            double other = low;
            low = high;
            high = other;
        }
        if (low > begin) begin = low;
        if (high < end) end = high;
    }
    return begin <= end ? begin : -1;
}

/* Where the ray hits the triangle before `end`; -1 if it does not (Moller and Trumbore 1997). */
static double hit(uint32_t triangle, const ray *r, double end) {
    double(*c)[3] = corners[triangle];
    double e1[3], e2[3], p[3], q[3], s[3], det = 0, u = 0, v = 0, t = 0;
    int i;
    for (i = 0; i < 3; i++) {
        e1[i] = c[1][i] - c[0][i];
        e2[i] = c[2][i] - c[0][i];
        s[i] = r->origin[i] - c[0][i];
    }
    for (i = 0; i < 3; i++) {
        int j = (i + 1) % 3, k = (i + 2) % 3;
        p[i] = r->direction[j] * e2[k] - r->direction[k] * e2[j];
        q[i] = s[j] * e1[k] - s[k] * e1[j];
    }
    for (i = 0; i < 3; i++) {
        det += e1[i] * p[i];
        u += s[i] * p[i];
        v += r->direction[i] * q[i];
        t += e2[i] * q[i];
    }
    if (det == 0) return -1;
    u /= det;
    v /= det;
    t /= det;
    return u >= 0 && v >= 0 && u + v <= 1 && t > 0 && t < end ? t : -1;
}

/* The triangle that the ray hits before `*end`, which becomes the distance; with `any`, the first one found. */
static uint32_t trace(rbt_tile *tile, const ray *r, double *end, int any) {
    uint32_t stack[STACK], entries = 0, node = 0, found = RBT_MISS;
    rbt_step(tile, RBT_NODE, 0);
    if (enter(&boxes[0], r, *end) < 0) return found;
    for (;;) {
        if (nodes[node].kind == RBT_INNER) {
            uint32_t left = nodes[node].first;
            double at_left = enter(&boxes[left], r, *end), at_right = enter(&boxes[left + 1], r, *end);
            rbt_step(tile, RBT_NODE, left); /* with its sibling */
            if (at_left >= 0 && at_right >= 0) {
                uint32_t is_right_nearer = at_right < at_left;
                rbt_step(tile, RBT_PUSH, entries);
                stack[entries++] = left + !is_right_nearer;
                node = left + is_right_nearer;
                continue;
            }
            if (at_left >= 0 || at_right >= 0) {
                node = left + (at_right >= 0);
                continue;
            }
        } else {
            uint32_t i;
            for (i = nodes[node].first; i < nodes[node].first + nodes[node].count; i++) {
                double at = hit(order[i], r, *end);
                rbt_step(tile, RBT_PRIMITIVE, i);
                if (at >= 0) {
                    *end = at;
                    found = order[i];
                    if (any) return found;
                }
            }
        }
        if (entries == 0) return found;
        node = stack[--entries];
        rbt_step(tile, RBT_POP, entries);
    }
}

static void trace_pixel(rbt_tile *tile, uint32_t number) {
    static const double light[3] = {-2.0, 2.5, 4.0};
    ray r = {{4.0, 5.0, -3.0}, {0.0, 0.0, 1.0}};
    double end = 1e30;
    uint32_t triangle;
    int axis;
    r.direction[0] = ((tile->x + number % tile->width + 0.5) / WIDTH - 0.5) * 1.6;
    r.direction[1] = (0.5 - (tile->y + number / tile->width + 0.5) / HEIGHT) * 1.6 - 0.9;
    rbt_begin_ray(tile, 0, number);
    triangle = trace(tile, &r, &end, 0);
    rbt_end_ray(tile, triangle);
    if (triangle == RBT_MISS) return; /* and no shadow ray is cast */
    for (axis = 0; axis < 3; axis++) {
        r.origin[axis] += end * r.direction[axis] + (axis == 1 ? 1e-6 : 0.0);
        r.direction[axis] = light[axis] - r.origin[axis];
    }
    end = 1.0;
    rbt_begin_ray(tile, 1, number);
    rbt_end_ray(tile, trace(tile, &r, &end, 1));
}

int main(int count, char **arguments) {
    static const rbt_ray_set sets[2] = {{"primary", 0, 0}, {"shadow", 0, 0}};
    rbt_header header;
    rbt_tree tree;
    rbt_writer writer;
    rbt_tile tile;
    uint32_t index, number;
    if (count != 2) {
        fputs("usage: example FILE.rbt\n", stderr);
        return 2;
    }
    make_hills();
    build(0, 0, TRIANGLES, 0);

    memset(&header, 0, sizeof header);
    header.generator = "example";
    header.scene = "hills";
    header.scene_hash = 1;
    header.width = WIDTH;
    header.height = HEIGHT;
    header.ray_sets = sets;
    header.ray_set_count = 2;
    header.accel = "bvh";
    header.traversal = "stack";
    header.node_fetch = "pair";
    header.loop_structure = "while-while";
    header.stack_entries = STACK;
    header.depth = depth;
    header.flat_normals = 1;
    memset(&tree, 0, sizeof tree);
    tree.nodes = nodes;
    tree.node_count = node_count;
    tree.references = order;
    tree.reference_count = tree.triangles = TRIANGLES;

    rbt_begin(&writer, arguments[1], &header, &tree);
    rbt_tile_init(&tile, &writer);
    for (index = 0; index < writer.tiles; index++) {
        rbt_tile_begin(&tile, index);
        for (number = 0; number < tile.width * tile.height; number++) trace_pixel(&tile, number);
        rbt_tile_end(&tile);
        rbt_write_tile(&writer, &tile);
    }
    rbt_tile_free(&tile);
    if (rbt_finish(&writer, 0) != RBT_OK) {
        fprintf(stderr, "error: %s\n", writer.message);
        return 1;
    }
    return 0;
}
