// A surface that lets shine through what lies behind: light premultiplied by alpha. The framebuffer
// encodes it. What the light does stands above (reflect.glsl).

out vec4 image;
in vec3 world_position;
in vec3 world_normal;
#ifdef COLORED
in vec4 color;
#endif
#ifdef FIRST_SET
in vec2 first_place;
#endif
#ifdef SECOND_SET
in vec2 second_place;
#endif

#ifdef BASE_MAP
// As four samples a pixel would read it: sharper at a slant than mipmaps alone, and drivers that
// draw on the processor take a tenth of the time that their anisotropic filter takes.
vec4 read_base(Place at)
{
    vec4 total = vec4(0.0);
    for (int i = 0; i < 4; ++i) {
        vec2 off = vec2(i & 1, i >> 1) * 0.5 - 0.25;
        total += read(base_map, Place(at.at + off.x * at.dx + off.y * at.dy, at.dx, at.dy), 0.5);
    }
    return 0.25 * total;
}
#endif

void main()
{
    Point p;
    p.position = world_position;
    p.dx = dFdx(world_position);
    p.dy = dFdy(world_position);
    p.normal = normalize(world_normal);
    p.normal_dx = dFdx(p.normal);
    p.normal_dy = dFdy(p.normal);
    p.side = 1.0;
#ifdef TWO_SIDED
    p.side = gl_FrontFacing ? 1.0 : -1.0;
#endif
    p.flat_normal = p.side * normalize(cross(p.dx, p.dy));
    p.reach = sqrt(0.5);
#ifdef FIRST_SET
    p.first_set = Place(first_place, dFdx(first_place), dFdy(first_place));
#endif
#ifdef SECOND_SET
    p.second_set = Place(second_place, dFdx(second_place), dFdy(second_place));
#endif
    vec4 base = base_color;
#ifdef BASE_MAP
    base *= read_base(placed(base_map_place, p.BASE_MAP));
#endif
#ifdef COLORED
    base *= color;
#endif
#ifdef LIT
    vec3 light = lit(base.rgb, p);
#else
    vec3 light = base.rgb;
#endif
    image = vec4(clamp(light, 0.0, 1.0) * base.a, base.a);
}
