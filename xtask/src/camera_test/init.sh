#!/bin/busybox sh
# The first program of the guest: loads the kernel's test cameras, runs the device tests, switches off.
/bin/busybox mkdir -p /proc /sys /dev /tmp /bin /etc
/bin/busybox mount -t proc none /proc
/bin/busybox mount -t sysfs none /sys
/bin/busybox mount -t devtmpfs none /dev
/bin/busybox --install -s /bin
export PATH=/bin
echo 'nobody:x:65534:65534:nobody:/:/bin/sh' > /etc/passwd
echo 'nogroup:x:65534:' > /etc/group
ifconfig lo 127.0.0.1 up
export FINGERVISION=/fingervision
depmod
# One camera with a node of images and one of metadata.
modprobe vivid n_devs=1 num_inputs=1 input_types=0 node_types=0x20001 || echo "GUEST: no vivid"
modprobe videodev
insmod /v4l2loopback.ko devices=2 video_nr=8,9 card_label=Loopback,Command exclusive_caps=1,1 max_buffers=4 || echo "GUEST: no v4l2loopback"
denied=without_permission
/devices --ignored --test-threads=1 --skip $denied
everything=$?
chmod 600 /dev/video*
su nobody -s /bin/sh -c "/devices --ignored --test-threads=1 $denied"
echo "GUEST: tests ended with $everything and $?"
poweroff -f
