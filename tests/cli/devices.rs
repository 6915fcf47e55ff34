//! The list of devices, and wishes.

use crate::sandbox::Sandbox;

/// The first device's name, as the program prints it.
fn first_name(list: &str) -> &str {
    let line = list.lines().find(|line| line.contains(" 0  ")).unwrap();
    line.split_once(" 0  ").unwrap().1
}

#[test]
fn the_devices_are_listed_and_the_choice_has_a_reason() {
    let list = Sandbox::new().run(["devices"]).done();
    assert!(!first_name(&list).is_empty());
    assert_eq!(list.lines().filter(|line| line.starts_with('*')).count(), 1, "{list}");
    let last = list.lines().last().unwrap();
    assert!(last.starts_with("chosen: ") && last.contains(", "), "{list}");
}

#[test]
fn a_device_is_found_by_number_by_part_of_its_name_and_by_cpu() {
    let sandbox = Sandbox::new();
    let list = sandbox.run(["devices"]).done();
    let part: String = first_name(&list).chars().take(5).collect::<String>().to_uppercase();
    for wish in ["0", part.as_str()] {
        let list = sandbox.run(["devices", "--device", wish]).done();
        assert!(list.contains("* 0") && list.contains("chosen: 0, named by the user"), "{wish}: {list}");
    }
    if list.contains("a software device,") {
        assert!(sandbox.run(["devices", "--device", "cpu"]).done().contains("a software device, as asked"));
    }
}

#[test]
fn a_device_that_is_not_there_is_wrong_use() {
    let sandbox = Sandbox::with_small_surface();
    for wish in ["nothing", "7", "18446744073709551616", "-1"] {
        let listed = sandbox.run(["devices", "--device", wish]);
        assert_eq!(listed.code, Some(2), "{listed:?}");
        assert_eq!(listed.stderr.lines().count(), 1, "{listed:?}");
        let line = sandbox.run(["render", "plate", "-o", "a.png", "--device", wish]).refused(2);
        assert!(line.contains(wish), "{line}");
    }
    assert!(!sandbox.path("a.png").exists());
}

#[test]
fn without_a_driver_every_command_that_needs_one_says_what_to_install() {
    let sandbox = Sandbox::with_small_surface().without_vulkan();
    for arguments in [&["devices"][..], &["render", "plate", "-o", "a.png"]] {
        let line = sandbox.run(arguments).refused(1);
        assert!(line.contains("install") && line.contains("mesa-vulkan-drivers"), "{line}");
    }
    assert!(!sandbox.path("a.png").exists());
}
