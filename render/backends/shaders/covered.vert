// A vertex into the image, for the number of the triangle that each sample shows.

uniform mat4 clip_from_world;
in vec3 in_position;
#ifdef MASKED
#ifdef COLORED
in vec4 in_color;
out vec4 color;
#endif
#ifdef BASE_MAP
in vec2 in_place;
out vec2 place;
#endif
#endif

void main()
{
    gl_Position = clip_from_world * vec4(in_position, 1.0);
#ifdef MASKED
#ifdef COLORED
    color = in_color;
#endif
#ifdef BASE_MAP
    place = in_place;
#endif
#endif
}
