#!/bin/sh
# Makes the clips that the tests read, each with FFmpeg's own decoding beside it:
#   NAME.png        every frame, or every fourth, below each other, 8-bit RGB
#   NAME.times      the presentation time of each frame, s
# Made with FFmpeg 5.1 and libx264. Other versions give other bytes, but the same pictures within the tests' tolerance.
set -eu
cd "$(dirname "$0")"

make() { ffmpeg -v error -y -fflags +bitexact "$@"; }

# Blobs of colour that drift over each other: smooth, so that how chroma is interpolated does not matter much.
scene() {
    echo "nullsrc=size=$1:rate=30:duration=0.4,geq=\
r='128+100*sin(X/9+N/3)*cos(Y/7)':g='128+90*sin(Y/8-N/4)':b='128+100*cos((X+Y)/11+N/5)',format=rgb24"
}

# reference CLIP MATRIX RANGE CHROMA STEP FRAMES [FILTER]: every STEP-th picture as FFmpeg decodes it. zimg makes RGB of it,
# with chroma interpolated linearly; FFmpeg's own conversion repeats chroma or puts it in the wrong place.
reference() {
    colour="zscale=matrixin=$2:rangein=$3:chromalin=$4:range=full:filter=bilinear,format=gbrp,format=rgb24"
    ffmpeg -v error -y -noautorotate -i "$1" -fps_mode passthrough -frames:v 1 -pred mixed -bitexact \
        -vf "$colour${7:-},select=not(mod(n\\,$5)),tile=1x$6" "${1%.*}.png"
    ffprobe -v error -select_streams v -show_entries frame=pts_time -of csv=p=0 "$1" |
        tr -d ',' | sed '/^$/d' > "${1%.*}.times"
}

x264="-c:v libx264 -preset veryslow -crf 16 -bitexact"

# As a robot writes it: B-frames and an edit list, limited range, nothing said about colour.
make -f lavfi -i "$(scene 48x32)" $x264 -pix_fmt yuv420p -bf 3 -g 8 b_frames.mp4
# As a phone writes it: sound, BT.709 in full range, no B-frames, held upright, a size that H.264 has to crop.
make -f lavfi -i "$(scene 46x30)" -f lavfi -i "sine=duration=0.4" -c:a aac -b:a 8k \
    -vf scale=out_color_matrix=bt709:out_range=full $x264 -pix_fmt yuvj420p -bf 0 \
    -colorspace bt709 -color_primaries bt709 -color_trc bt709 upright.mp4
make -i upright.mp4 -c copy -metadata:s:v rotate=90 -movflags +faststart phone.mp4
rm upright.mp4
# Frames at uneven times.
make -f lavfi -i "$(scene 48x32)" -vf "select='not(eq(mod(n,4),2))'" -fps_mode vfr $x264 -pix_fmt yuv420p uneven.mp4
# The first quarter cut away without decoding: an edit list hides what the rest is built on.
make -f lavfi -i "$(scene 48x32)" $x264 -pix_fmt yuv420p -bf 2 -g 30 long.mp4
make -ss 0.1 -i long.mp4 -c copy trimmed.mp4
rm long.mp4
# Written in pieces while recording, field-free 4:2:2.
make -f lavfi -i "$(scene 48x32)" $x264 -pix_fmt yuv422p -bf 2 -g 4 \
    -movflags frag_keyframe+empty_moov+default_base_moof fragments.mov
# Motion JPEG.
make -f lavfi -i "$(scene 48x32)" -c:v mjpeg -q:v 2 -pix_fmt yuvj422p -bitexact colour.avi
make -f lavfi -i "$(scene 48x32)" -c:v mjpeg -q:v 2 -pix_fmt yuvj420p -bitexact jpeg.mov
# In MP4 the same codec is an MPEG-4 object type: the pictures of jpeg.mov with sound, and pieces with odd sides and full
# chroma.
make -f lavfi -i "$(scene 48x32)" -f lavfi -i "sine=duration=0.4" -c:a aac -b:a 8k \
    -c:v mjpeg -q:v 2 -pix_fmt yuvj420p -bitexact jpeg.mp4
make -f lavfi -i "$(scene 47x31)" -c:v mjpeg -q:v 2 -pix_fmt yuvj444p -bitexact \
    -movflags frag_every_frame+empty_moov odd_jpeg.mp4

reference b_frames.mp4 170m limited left 1 12
reference phone.mp4 709 full left 4 3 ,transpose=cclock
reference uneven.mp4 170m limited left 4 3
reference trimmed.mp4 170m limited left 4 3
reference fragments.mov 170m limited left 4 3
reference colour.avi 170m full center 4 3
reference jpeg.mov 170m full center 4 3
reference odd_jpeg.mp4 170m full center 4 3

# What is not read.
tiny="nullsrc=size=32x32:rate=30:duration=0.1,format=yuv420p"
make -f lavfi -i "$tiny" -c:v libx265 -x265-params log-level=none -tag:v hvc1 -bitexact h265.mp4
make -f lavfi -i "$tiny" -c:v libvpx-vp9 -bitexact vp9.webm
make -f lavfi -i "$tiny" -c:v libx264 -pix_fmt yuv420p10le -bitexact ten_bit.mp4
make -f lavfi -i "$tiny" -c:v mpeg2video -bitexact mpeg2.mp4
make -f lavfi -i "$tiny" -c:v libx264 -bitexact h264.avi

# references.mp4 is trimmed.mp4 with some bytes of its pictures changed by chance: a slice asks for 1566271659 references.
