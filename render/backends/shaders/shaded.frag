// The light of one part of a mesh, times the share of each pixel that it covers: each triangle that a
// pixel's samples show is lit once, or each sample by itself where SHARP is defined. Vertices are
// fetched, so that how everything changes from pixel to pixel is exact. What the light does stands
// above (reflect.glsl).

out vec4 image;
uniform usampler2DMS covered;
uniform usamplerBuffer corners;
uniform samplerBuffer vertices;
uniform vec2 samples[4];
uniform mat3 ray_from_pixel;
uniform vec3 seen_from;
uniform uint first;
uniform uint stop;
uniform int first_corner;
#ifdef COLORED
uniform samplerBuffer colors;
#endif
#ifdef FIRST_SET
uniform samplerBuffer first_places;
#endif
#ifdef SECOND_SET
uniform samplerBuffer second_places;
#endif

struct Corner {
    int number;
    vec3 position;
    vec3 normal;
};

Corner corner(int place)
{
    int number = int(texelFetch(corners, place).r);
    vec2 a = texelFetch(vertices, 3 * number).rg;
    vec2 b = texelFetch(vertices, 3 * number + 1).rg;
    vec2 c = texelFetch(vertices, 3 * number + 2).rg;
    return Corner(number, vec3(a, b.x), vec3(b.y, c));
}

#if defined(FIRST_SET) || defined(SECOND_SET)
Place mixed(samplerBuffer places, ivec3 numbers, vec3 share, vec3 dx, vec3 dy)
{
    mat3x2 all = mat3x2(texelFetch(places, numbers.x).rg, texelFetch(places, numbers.y).rg,
                        texelFetch(places, numbers.z).rg);
    return Place(all * share, all * dx, all * dy);
}
#endif

// How a unit vector changes where one of the same direction does.
vec3 turning(vec3 unit, vec3 change, float size)
{
    return (change - unit * dot(unit, change)) / size;
}

vec3 light_of(uint id, vec2 at, vec4 held)
{
    float count = dot(held, vec4(1.0));
    int place = first_corner + 3 * int(id - first);
    Corner a = corner(place);
    Corner b = corner(place + 1);
    Corner c = corner(place + 2);
    vec3 ab = b.position - a.position;
    vec3 ac = c.position - a.position;
    vec3 away = a.position - seen_from;
    vec3 n = cross(ab, ac);
    vec3 ray = ray_from_pixel * vec3(at, 1.0);
    float fall = dot(n, ray);
    float depth = dot(n, away) / fall;
    Point p;
    // From the first corner, which is near: the eye may be far.
    vec3 off = depth * ray - away;
    p.dx = depth * (ray_from_pixel[0] - ray * (dot(n, ray_from_pixel[0]) / fall));
    p.dy = depth * (ray_from_pixel[1] - ray * (dot(n, ray_from_pixel[1]) / fall));
    float square = dot(n, n);
    vec3 to_b = cross(ac, n) / square;
    vec3 to_c = cross(n, ab) / square;
    vec2 both = vec2(dot(to_b, off), dot(to_c, off));
    // What a sample shows is light from the middle of its quarter of the pixel, or as near as may be.
    vec3 share = clamp(vec3(1.0 - both.x - both.y, both), 0.0, 1.0);
    share /= dot(share, vec3(1.0));
    both = vec2(dot(to_b, p.dx), dot(to_c, p.dx));
    vec3 share_dx = vec3(-both.x - both.y, both);
    both = vec2(dot(to_b, p.dy), dot(to_c, p.dy));
    vec3 share_dy = vec3(-both.x - both.y, both);
    p.position = a.position + share.y * ab + share.z * ac;
    p.side = 1.0;
#ifdef TWO_SIDED
    p.side = fall < 0.0 ? 1.0 : -1.0;
#endif
    p.flat_normal = n * inversesqrt(square);
    mat3 normals = mat3(a.normal, b.normal, c.normal);
    vec3 mean = normals * share;
    float size = length(mean);
    p.normal = mean / size;
    p.normal_dx = turning(p.normal, normals * share_dx, size);
    p.normal_dy = turning(p.normal, normals * share_dy, size);
    p.reach = 0.5 * sqrt(sqrt(count));
    ivec3 numbers = ivec3(a.number, b.number, c.number);
#ifdef FIRST_SET
    p.first_set = mixed(first_places, numbers, share, share_dx, share_dy);
#endif
#ifdef SECOND_SET
    p.second_set = mixed(second_places, numbers, share, share_dx, share_dy);
#endif
    vec3 base = base_color.rgb;
#ifdef BASE_MAP
    Place own = placed(base_map_place, p.BASE_MAP);
#ifdef SHARP
    base *= read(base_map, own, 0.5).rgb;
#else
    // Read where the samples are: sharper at a slant than mipmaps alone.
    vec3 total = vec3(0.0);
    for (int i = 0; i < 4; ++i) {
        vec2 by = floor(at) + samples[i] - at;
        total += held[i] * read(base_map, Place(own.at + by.x * own.dx + by.y * own.dy, own.dx,
                                                own.dy), 0.5).rgb;
    }
    base *= total / count;
#endif
#endif
#ifdef COLORED
    mat3 tints = mat3(texelFetch(colors, a.number).rgb, texelFetch(colors, b.number).rgb,
                      texelFetch(colors, c.number).rgb);
    base *= tints * share;
#endif
#ifdef LIT
    return lit(base, p);
#else
    return base;
#endif
}

void main()
{
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    uvec4 ids = uvec4(texelFetch(covered, pixel, 0).r, texelFetch(covered, pixel, 1).r,
                      texelFetch(covered, pixel, 2).r, texelFetch(covered, pixel, 3).r);
    uvec4 waiting = uvec4(lessThan(ids - first, uvec4(stop - first)));
    vec4 total = vec4(0.0);
    // Drivers that draw on the processor skip the rest of a loop, but of a branch nothing.
    do {
        int next = waiting.x != 0u ? 0 : waiting.y != 0u ? 1 : waiting.z != 0u ? 2 : 3;
        uint id = ids[next];
#ifdef SHARP
        uvec4 same = uvec4(equal(ivec4(0, 1, 2, 3), ivec4(next)));
#else
        uvec4 same = uvec4(equal(ids, uvec4(id)));
#endif
        vec4 share = vec4(same);
        float count = dot(share, vec4(1.0));
        vec2 middle = (share.x * samples[0] + share.y * samples[1] + share.z * samples[2]
            + share.w * samples[3]) / count;
        vec3 light = clamp(light_of(id, vec2(pixel) + middle, share), 0.0, 1.0);
        total += 0.25 * count * vec4(light, 1.0);
        waiting &= ~same & 1u;
    } while (waiting != uvec4(0u));
    image = total;
}
